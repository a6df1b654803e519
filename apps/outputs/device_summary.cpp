#include "apps/outputs/device_summary.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/guard/device_test.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Json known(double value) { return value > 0 && std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

Json device_json(const ToolRun& tool) {
  const DeviceRun& run = *tool.device;
  const SafetyCounts& s = run.safety;
  std::vector<double> age(tool.pose_age.begin(), tool.pose_age.end());
  std::ranges::sort(age);
  Json out{{"backend", run.name}, {"name", run.info.name}, {"serial", run.info.serial}};
  out["max_force_n"] = run.max_force;
  out["continuous_force_n"] = known(run.info.continuous_force);
  out["gives_force"] = run.info.gives_force;
  out["gives_torque"] = run.info.gives_torque;
  out["origin_m"] = {run.origin.x(), run.origin.y(), run.origin.z()};
  out["pose_age_ms"] = {{"p50", known(1e3 * sorted_percentile(age, 0.5))},
                        {"p99", known(1e3 * sorted_percentile(age, 0.99))}};
  out["delay_ms"] = {{"reckoned", 1e3 * run.delay.delay},
                     {"measured", run.delay.measured},
                     {"p50", known(1e3 * run.delay.p50)},
                     {"p99", known(1e3 * run.delay.p99)}};
  out["coupling_n_per_m"] = known(run.coupling);
  out["gate"] = name_of(run.gate);
  out["ticks"] = {{"gated", s.gated},           {"stale", s.stale}, {"slewed", s.slewed},    {"limited", s.limited},
                  {"not_finite", s.not_finite}, {"shut", s.shut},   {"unechoed", s.unechoed}};
  out["turning"] = nullptr;  // what its torque gave, as "passivity" has it of the force
  if (run.turning) out["turning"] = {{"energy_min_j", run.turning->least}, {"damped_ticks", run.turning->damped_ticks}};
  out["ticks_by_gate"] = Json::object();
  for (std::size_t i = 1; i < kGateReasons; ++i)
    if (s.by_reason[i] > 0) out["ticks_by_gate"][name_of(static_cast<GateReason>(i))] = s.by_reason[i];
  out["jumps"] = s.jumps;
  out["notes"] = run.notes;
  out["most_force_n"] = s.most_force;  // that was sent
  out["most_echoed_n"] = s.most_echoed ? Json(*s.most_echoed) : Json(nullptr);
  out["most_slew_n_per_s"] = s.most_slew;
  return out;
}

std::string device_line(const Json& d) {
  const std::string serial = d["serial"].get<std::string>();
  const bool repeats = !d["most_echoed_n"].is_null();  // what a device gives is what its service says that it took
  std::string out = text(d["name"].get<std::string>(), serial.empty() ? "" : " " + serial, ": at most ",
                         short_number(d["max_force_n"]), " N, gave up to ",
                         short_number(d[repeats ? "most_echoed_n" : "most_force_n"]), " N");
  if (repeats) out += text(" of ", short_number(d["most_force_n"]), " N that it was sent");
  if (!d["pose_age_ms"]["p50"].is_null())
    out +=
        text("; pose age ", short_number(d["pose_age_ms"]["p50"]), " ms, p99 ", short_number(d["pose_age_ms"]["p99"]));
  if (!d["delay_ms"]["p50"].is_null())
    out += text("; forces act after ", short_number(d["delay_ms"]["p50"]), " ms, p99 ",
                short_number(d["delay_ms"]["p99"]));
  if (!d["coupling_n_per_m"].is_null()) out += text("; coupling ", short_number(d["coupling_n_per_m"]), " N/m");
  return out + text("; gate not open in ", d["ticks"]["gated"], " ticks, poses stale in ", d["ticks"]["stale"],
                    "; at the end: ", d["gate"].get<std::string>());
}

}  // namespace kt
