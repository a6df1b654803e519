#pragma once
// What stands in the way of a good touch, from a test: each cause once, and what to do about it.
#include "core/base/finding.hpp"
#include "haptics/guard/device_test.hpp"

namespace kt {

/// What a person has to do for a gate that is shut; empty: the reason says it.
std::string gate_advice(GateReason reason, const std::string& backend);

/// @param backend  in device.def   Empty: nothing does.
std::vector<Finding> find_troubles(const std::string& backend, const DeviceInfo& info, const DeviceTest& test,
                                   double rate_hz);

}  // namespace kt
