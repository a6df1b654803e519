#include "haptics/driver/device_troubles.hpp"

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/driver/find_devices.hpp"

namespace kt {
namespace {

std::string shown(double value) { return with_digits(value, 3); }

/// The gate is meant to be shut at the test's beginning, and by the person.
bool is_told(GateReason reason) {
  return reason != GateReason::open && reason != GateReason::no_model && reason != GateReason::put_down;
}

void find_shut_gates(const std::string& backend, const DeviceTest& t, double rate_hz, std::vector<std::string>& out) {
  for (std::size_t i = 0; i < kGateReasons; ++i) {
    const auto reason = static_cast<GateReason>(i);
    const int ticks = t.safety.by_reason[i];
    const bool is_last = reason == t.gate;
    constexpr double kBriefly = 1e-3;  // share of the ticks
    if (!is_told(reason) || (!is_last && ticks <= kBriefly * t.ticks)) continue;
    const std::string advice = gate_advice(reason, backend);
    out.push_back(text("no force ", is_last ? "at the end" : "at times", ", for ", shown(ticks / rate_hz),
                       " s: ", name_of(reason), advice.empty() ? "" : "; " + advice));
  }
}

}  // namespace

std::string gate_advice(GateReason reason, const std::string& backend) {
  switch (reason) {
    case GateReason::uncalibrated:
      return calibration_advice(backend);
    case GateReason::stale_pose:
      return "the device's driver or this computer is held up (kilotouch device test --machine)";
    case GateReason::gone:
      return "see to its cable, its power, and the maker's service";
    case GateReason::unpowered:
      return "connect its supply, and switch it on";
    case GateReason::in_use:
      return "end the other program";
    case GateReason::altered:
      return "see to mount, preset, basis and force_scale in the maker's program";
    case GateReason::no_echo:
      return "its motors get nothing: the service takes forces under another name, or not from us";
    case GateReason::jumped:
      return "see to the device's sensors and cable";
    default:
      return {};
  }
}

std::vector<std::string> find_troubles(const std::string& backend, const DeviceInfo& info, const DeviceTest& t,
                                       double rate_hz) {
  std::vector<std::string> out;
  find_shut_gates(backend, t, rate_hz, out);
  const bool has_shut = !out.empty();
  if (t.safety.jumps > 0)
    out.push_back(text("the pose leapt ", t.safety.jumps, " times as no hand moves (faster than ",
                       FollowedPose::kMostSpeed, " m/s): see to the device's sensors and cable"));
  if (!has_shut && t.safety.most_echoed && *t.safety.most_echoed < 0.9 * t.safety.most_force)
    out.push_back(text("of a force of ", shown(t.safety.most_force), " N the service repeats ",
                       shown(*t.safety.most_echoed), " N: something on the way makes it smaller"));
  if (t.readings_per_s < 0.9 * rate_hz && t.there > 0.5)
    out.push_back(text("fresh poses came ", shown(t.readings_per_s), " times a second, ticks ", rate_hz,
                       " times: lower local.rate_hz, or see to the device's service"));
  if (sorted_percentile(t.lateness, 0.99) > 1 / rate_hz)
    out.push_back(text("one tick in a hundred came more than a period late (",
                       shown(1e3 * sorted_percentile(t.lateness, 0.99)),
                       " ms): kilotouch device test --machine says why"));
  if (!info.gives_force || has_shut) return out;
  if (t.deepest > 0 && t.ripple > 0.1)
    out.push_back(text("the force on the wall swung by ", shown(100 * t.ripple),
                       " % of its mean: kilotouch device identify, and then tool.path.device.damping"));
  if (!(t.deepest > 0)) out.push_back("the wall was not touched: press the device down by 1 cm");
  return out;
}

}  // namespace kt
