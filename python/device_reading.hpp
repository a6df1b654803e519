#pragma once
#include "haptics/device/haptic_device.hpp"
#include "python/made_only.hpp"

namespace kt {

/// A device at one moment, in the world's frame.
struct DeviceReadingAt {
  Pose pose;
  DeviceState state;
};

}  // namespace kt

KT_MADE_ONLY(kt::DeviceReadingAt);
