#pragma once
// Counts heap allocations of the calling thread, from every library: the program's own malloc stands in front of
// libc's.

namespace kt {

/// Allocations of this thread since it began; -1 in a build that cannot count (sanitizers bring their own malloc).
long long thread_allocations();

}  // namespace kt
