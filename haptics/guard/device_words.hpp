#pragma once
// What is said of a device that somebody holds and was not given its force: in the same words of a scene's run
// (findings/) and of a loop of one's own (api/held_touch.hpp).
#include <string>

#include "haptics/guard/safety_chain.hpp"

namespace kt {

/// The gate was never fully open, in no tick.
bool never_opened(const SafetyCounts& counts) noexcept;
/// @param in_contact  ", 3 of 9 in contact"; empty where that is not known
std::string gate_words(const SafetyCounts& counts, const std::string& in_contact = "");
std::string limited_words(int ticks);
/// @param share  of ticks: "3 of 9 ticks in contact"
std::string slewed_words(const std::string& share);
std::string stale_pose_words(const std::string& share);
std::string leap_words(int jumps);

}  // namespace kt
