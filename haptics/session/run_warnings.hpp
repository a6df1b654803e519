#pragma once
// What a user of a run has to know before trusting its forces.
#include <string>
#include <vector>

#include "haptics/session/session.hpp"

namespace kt {

/// The run's own warnings and those that its ticks, global steps and refreshes show, one line a kind, with how many of
/// how many.
/// @param keeps_outside  the method lets no tool into the body, so depth is worth a warning
std::vector<std::string> run_warnings(const SessionResult& result, bool keeps_outside);

/// More places touched at once than are resolved, and the forces were not found for it.
bool contacts_were_too_many(const SessionResult& result);

/// A tool was inside the body without contact, or went through it, in a run that has to keep it outside.
bool contact_was_lost(const SessionResult& result, bool keeps_outside);

}  // namespace kt
