#pragma once
// Threads of ours in a Python process, and its end: no thread of ours may wait for the interpreter when that is gone.
#include <Python.h>

#include <functional>

namespace kt {

/// Without the interpreter's lock. At the end of Python a thread that would take it again stays where it is: it would
/// be ended in the middle of C++ otherwise.
class NoGil {
 public:
  NoGil() : state_(PyEval_SaveThread()) {}
  ~NoGil();
  NoGil(const NoGil&) = delete;
  NoGil& operator=(const NoGil&) = delete;

 private:
  PyThreadState* state_;
};

/// For atexit, first: Python ends, nothing new begins, and other threads than this one stay where they leave NoGil.
void begin_ending() noexcept;

/// Runs it in a thread of its own, for which the end of Python waits. Throws RunError.
/// @param stop  is called then; empty: it ends by itself
void in_background(std::function<void()> work, std::function<void()> stop = {});

/// For atexit, last: what runs is stopped and waited for.
void end_background();

/// Whether this thread is in a call of a Python model: what would wait for the body must not be called there.
bool& is_in_model() noexcept;
/// Whether Ctrl-C came in such a call of this thread, and is still to be told.
bool& was_interrupted() noexcept;

}  // namespace kt
