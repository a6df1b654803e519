#pragma once
// What a user of a run has to know before trusting its forces.
#include <string>
#include <vector>

#include "haptics/session.hpp"

namespace kt {

/// The run's own warnings and those that its ticks, global steps and refreshes show, one line a kind, with how many of
/// how many.
/// @param keeps_outside  the method lets no tool into the body, so depth is worth a warning
std::vector<std::string> run_warnings(const SessionResult& result, bool keeps_outside);

}  // namespace kt
