#pragma once
// Looks at ticks from outside the engine: checks, records. None: nobody looks.
#include "haptics/touch/haptic_side.hpp"

namespace kt {

class TickObserver {
 public:
  virtual ~TickObserver() = default;

  // In the thread that ticks: no allocation where ticks are against the wall clock, no lock.

  /// The local model in use from now on.
  virtual void adopted(const PreparedLocalModel& /*model*/) noexcept {}
  /// A tick is done; `side` is as it left it.
  virtual void ticked(const HapticSide& /*side*/, std::span<const LocalFrame> /*frames*/) noexcept {}

  // In the body's thread, where it has one.

  /// Up to `most` of the ticks that this local model was in use for, which is over. False: none is left of them.
  virtual bool look_back(const PreparedLocalModel& /*model*/, int /*most*/) { return false; }
};

}  // namespace kt
