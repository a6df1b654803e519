#pragma once
// Which devices there are: haptics/device/device.def.
#include <vector>

#include "core/base/backend.hpp"

namespace kt {

std::vector<BackendInfo> device_backends();
std::vector<BackendInfo> live_device_backends();  ///< those that tool.path.device names

}  // namespace kt
