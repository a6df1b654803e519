#pragma once
// What a device is like by itself, hands off: a soft spring is rendered at it, its rest place jumps, and the swing is
// fitted.
#include <atomic>

#include "haptics/guard/safety_chain.hpp"
#include "haptics/safety/identify.hpp"

namespace kt {

struct IdentifyOptions {
  double h = 1e-3;         ///< tick [s]
  double jump = 0.015;     ///< [m] of the spring's rest place, at the device's scale
  int axis = 0;            ///< of the world, along which it jumps: 0 is x, which no gravity pulls along
  double seconds = 1.5;    ///< that are fitted, after half a second in which the gate opens
  SafetyOptions safety{};  ///< its device, h, damper and coupling are filled in: nothing may damp but the device
  const std::atomic<bool>* stop = nullptr;
};

/// @param device  open, let go of by the hand; borrowed
DeviceFit identify_device(HapticDevice& device, const IdentifyOptions& options);

}  // namespace kt
