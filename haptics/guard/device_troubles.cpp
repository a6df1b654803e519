#include "haptics/guard/device_troubles.hpp"

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/driver/find_devices.hpp"
#include "haptics/guard/followed_pose.hpp"

namespace kt {
namespace {

/// The gate is meant to be shut at the test's beginning, and by the person.
bool is_told(GateReason reason) {
  return reason != GateReason::open && reason != GateReason::no_model && reason != GateReason::put_down;
}

void find_shut_gates(const std::string& backend, const DeviceTest& t, double rate_hz, std::vector<Finding>& out) {
  for (std::size_t i = 0; i < kGateReasons; ++i) {
    const auto reason = static_cast<GateReason>(i);
    const int ticks = t.safety.by_reason[i];
    const bool is_last = reason == t.gate;
    constexpr double kBriefly = 1e-3;  // share of the ticks
    if (!is_told(reason) || (!is_last && ticks <= kBriefly * t.ticks)) continue;
    const std::string advice = gate_advice(reason, backend);
    out.push_back(
        {told("no force ", is_last ? "at the end" : "at times", ", for ", ticks / rate_hz, " s: ", name_of(reason)),
         advice.empty() ? std::vector<Cure>{} : std::vector{advise(advice)}});
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

std::vector<Finding> find_troubles(const std::string& backend, const DeviceInfo& info, const DeviceTest& t,
                                   double rate_hz) {
  std::vector<Finding> out;
  find_shut_gates(backend, t, rate_hz, out);
  const bool has_shut = !out.empty();
  if (t.safety.jumps > 0)
    out.push_back({told("the pose leapt ", t.safety.jumps, " times as no hand moves (faster than ",
                        FollowedPose::kMostSpeed, " m/s)"),
                   {advise("see to the device's sensors and cable")}});
  if (!has_shut && t.safety.most_echoed && *t.safety.most_echoed < 0.9 * t.safety.most_force)
    out.push_back({told("of a force of ", t.safety.most_force, " N the service repeats ", *t.safety.most_echoed,
                        " N: something on the way makes it smaller")});
  if (t.readings_per_s < 0.9 * rate_hz && t.there > 0.5)
    out.push_back({told("fresh poses came ", t.readings_per_s, " times a second, ticks ", rate_hz, " times"),
                   {advise("lower local.rate_hz"), advise("see to the device's service")}});
  if (sorted_percentile(t.lateness, 0.99) > 1 / rate_hz)
    out.push_back({told("one tick in a hundred came more than a period late (",
                        1e3 * sorted_percentile(t.lateness, 0.99), " ms)"),
                   {advise("kilotouch device test --machine says why")}});
  if (!info.gives_force || has_shut) return out;
  if (t.deepest > 0 && t.ripple > 0.1)
    out.push_back({told("the force on the wall swung by ", in_percent(t.ripple), " of its mean"),
                   {advise("kilotouch device identify, and then tool.path.device.damping")}});
  if (!(t.deepest > 0)) out.push_back({"the wall was not touched", {advise("press the device down by 1 cm")}});
  return out;
}

}  // namespace kt
