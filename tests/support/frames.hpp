#pragma once
// Bits of what a run gives.
#include <cstdint>
#include <span>

#include "core/body/state.hpp"
#include "haptics/tick/local_frame.hpp"

namespace kt {

inline std::uint64_t hash_of(std::span<const LocalFrame> frames) {
  StateHash hash;
  for (const LocalFrame& f : frames) {
    hash.add(f.pose.x);
    hash.add(f.force);
    hash.add(f.toi);
    hash.add(static_cast<int>(f.mode));
    hash.add(f.triangle);
  }
  return hash.value();
}

}  // namespace kt
