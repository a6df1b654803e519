#pragma once
// Which devices are there, without a run.
#include <string>
#include <vector>

#include "core/base/settings.hpp"
#include "haptics/driver/device_slots.hpp"

namespace kt {

/// The devices of one backend (LIVE_DEVICE in haptics/device/device.def) that are connected now. Where the backend
/// cannot look at all, as without its maker's library, one entry without an id, whose trouble says why. None of a
/// backend that this build leaves out. Opens devices for a moment: not while one of that backend is in use.
/// @param settings  its address, library and id are used; with an id, only what is asked for
std::vector<FoundDevice> find_devices(const std::string& name, const DeviceSettings& settings);

/// What a person has to do with a device whose health is uncalibrated; empty: it never is.
std::string calibration_advice(const std::string& name);

/// "tool.path.device: NAME: several are connected (ids); name one in tool.path.device.id", or that `id` is not among
/// them.
[[noreturn]] void throw_which_device(const std::string& name, const std::string& id,
                                     const std::vector<std::string>& ids);

}  // namespace kt
