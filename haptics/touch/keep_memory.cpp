#include "haptics/touch/keep_memory.hpp"

#include <malloc.h>

namespace kt {

void keep_freed_memory() noexcept {
  static const bool done = mallopt(M_MMAP_THRESHOLD, 1 << 30) != 0 && mallopt(M_TRIM_THRESHOLD, 1 << 30) != 0;
  (void)done;
}

}  // namespace kt
