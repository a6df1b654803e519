#pragma once
// A device outside the program, as the haptic tick sees it: in the world's frame, with an age and a health.
#include <functional>

#include "haptics/driver/device_frame.hpp"
#include "haptics/driver/device_slots.hpp"

namespace kt {

/// Opens a device and starts what keeps the slots up to date. Throws InputError: one line, what to do.
using OpenDriver = std::unique_ptr<DeviceDriver> (*)(const DeviceSettings& settings, DeviceSlots& slots);

/// Opens the device, waits for its first reading (2 s at most) and says where its zero lies. Throws InputError.
std::unique_ptr<HapticDevice> make_live_device(const DeviceOptions& options, OpenDriver open);

/// Of SCHED_FIFO for a driver's own thread: above the tick's, whose pose it brings.
constexpr int kIoPriority = 60;

/// A pose that is older than this is stale [s].
constexpr double kOldestPose = 5e-3;

}  // namespace kt
