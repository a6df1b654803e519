#include "haptics/touch/keep_memory.hpp"

#include <malloc.h>

namespace kt {

void keep_freed_memory() noexcept {
  // One arena: those of other threads give each emptied heap of 64 MB back, whatever the threshold.
  static const bool done = mallopt(M_MMAP_THRESHOLD, 1 << 30) != 0 && mallopt(M_TRIM_THRESHOLD, 1 << 30) != 0 &&
                           mallopt(M_ARENA_MAX, 1) != 0;
  (void)done;
}

}  // namespace kt
