#pragma once
// Whether this computer keeps haptic rates, as text for the person who has to mend it and as JSON for programs.
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/machine/machine_test.hpp"

namespace kt {

/// A table of the rates, then each thing in the way: what, where it was read, the value, the cure.
std::string machine_text(const MachineReport& report);

nlohmann::ordered_json machine_json(const MachineReport& report);

}  // namespace kt
