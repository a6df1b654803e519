#pragma once
#include "haptics/device/haptic_device.hpp"

namespace kt {

/// A device at one moment, in the world's frame.
struct DeviceReadingAt {
  Pose pose;
  DeviceState state;
};

}  // namespace kt
