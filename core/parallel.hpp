#pragma once
// Independent pieces of work on all cores: Intel's TBB, or one after the other in the minimal build.
#include <functional>

namespace kt {

/// Calls work(i) for i = 0 .. count - 1, in any order and from several threads; returns when all are done. The pieces
/// must not write to the same place: then the result does not depend on the number of threads.
void parallel_for(int count, const std::function<void(int)>& work);

}  // namespace kt
