#pragma once
// Independent pieces of work on all cores: Intel's TBB, or one after the other in the minimal build.
#include <functional>

namespace kt {

/// Calls work(i) for i = 0 .. count - 1, in any order and from several threads; returns when all are done. The pieces
/// must not write to the same place: then the result does not depend on the number of threads.
void parallel_for(int count, const std::function<void(int)>& work);

/// Calls work() with `threads` threads for the pieces of all that it calls, more than there are cores if it must be: to
/// measure, and to test that results stay the same. One call at a time in the process.
void with_threads(int threads, const std::function<void()>& work);

}  // namespace kt
