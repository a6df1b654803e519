#include "haptics/guard/device_words.hpp"

#include "core/base/numbers.hpp"

namespace kt {
namespace {

std::string times(int count) { return told(count, count == 1 ? " time" : " times"); }

}  // namespace

bool never_opened(const SafetyCounts& counts) noexcept { return counts.ticks > 0 && counts.gated == counts.ticks; }

std::string gate_words(const SafetyCounts& counts, const std::string& in_contact) {
  const GateReason why = main_reason(counts);
  return told("the device's gate ",
              never_opened(counts)
                  ? "never opened fully"
                  : told("was shut or not fully open in ", counts.gated, " of ", counts.ticks, " ticks"),
              in_contact, why == GateReason::open ? std::string() : told(": mostly because ", name_of(why)),
              counts.shut > 0 ? "; it shut " + times(counts.shut) : "");
}

std::string limited_words(int ticks) { return told("the force was cut to the device's limit in ", ticks, " ticks"); }

std::string slewed_words(const std::string& share) {
  return "the force was held back from changing faster than the device is allowed in " + share;
}

std::string stale_pose_words(const std::string& share) {
  return "the device's pose was too old, or the device not there, in " + share;
}

std::string leap_words(int jumps) {
  return told("the device's pose leapt ", times(jumps), " as no hand moves: it was not followed, and the gate shut");
}

}  // namespace kt
