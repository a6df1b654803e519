#pragma once
// What must hold of any input, else the fuzzer has found something.
#include <cstdio>
#include <cstdlib>

namespace kt::fuzz {

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "not so: %s\n", what);
  std::abort();
}

}  // namespace kt::fuzz
