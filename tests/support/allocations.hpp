#pragma once
// How often a piece of code asks for memory.
#include "apps/console/allocation_counter.hpp"

namespace kt {

/// Heap allocations of this thread while f runs; 0 in a build that cannot count (sanitizers bring their own malloc).
template <class F>
long long allocations_during(F&& f) {
  const long long before = thread_allocations();
  f();
  return thread_allocations() - before;
}

}  // namespace kt
