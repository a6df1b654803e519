// A library that has none of the functions that a driver asks for.
extern "C" int fake_nothing() { return 0; }
