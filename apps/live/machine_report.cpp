#include "apps/live/machine_report.hpp"

#include <cstdio>

#include "core/base/error.hpp"

namespace kt {
namespace {

std::string rate_row(const WakeUps& w) {
  char out[160];
  std::snprintf(out, sizeof out, "  %6.0f Hz  %8.1f us  %8.1f us  %8.1f us  %8.1f us  %8d   %s\n", w.rate_hz, w.p50_us,
                w.p99_us, w.p999_us, w.max_us, w.over_period, name_of(w.kept));
  return out;
}

std::string verdict_on(const MachineReport& r) {
  const double fastest = r.fastest_kept_hz();
  double wanted = 0;
  for (const WakeUps& w : r.rates) wanted = std::max(wanted, w.rate_hz);
  if (fastest == 0) return "This computer keeps none of these rates.";
  if (fastest == wanted) return text("This computer keeps ", fastest, " Hz.");
  return text("This computer keeps ", fastest, " Hz, and not ", wanted, " Hz.");
}

}  // namespace

std::string machine_text(const MachineReport& r) {
  std::string out =
      text("Ticks against the clock", r.busy ? ", every core busy with other work" : "", "\n", "  thread     ",
           r.grant.told(), "\n", "    rate     late: half    99 of 100   999 of 1000        most  > period   kept\n");
  for (const WakeUps& w : r.rates) out += rate_row(w);
  out += verdict_on(r) + "\n";
  if (r.findings.empty()) return out + "Nothing was found that stands in the way.\n";
  out += "What stands in the way, the heaviest first:\n";
  for (const MachineFinding& f : r.findings)
    out += text("  - ", f.what, "\n    read   ", f.where, ": ", f.value, "\n    cure   ", f.cure, "\n");
  return out;
}

nlohmann::ordered_json machine_json(const MachineReport& r) {
  using Json = nlohmann::ordered_json;
  Json rates = Json::array(), findings = Json::array();
  for (const WakeUps& w : r.rates)
    rates.push_back({{"rate_hz", w.rate_hz},
                     {"wake_ups", w.count},
                     {"late_us", {{"p50", w.p50_us}, {"p99", w.p99_us}, {"p999", w.p999_us}, {"max", w.max_us}}},
                     {"over_period", w.over_period},
                     {"kept", name_of(w.kept)}});
  for (const MachineFinding& f : r.findings)
    findings.push_back({{"what", f.what}, {"where", f.where}, {"value", f.value}, {"cure", f.cure}});
  return {{"busy", r.busy},
          {"rates", rates},
          {"fastest_kept_hz", r.fastest_kept_hz()},
          {"thread",
           {{"scheduler", r.grant.scheduler()},
            {"priority", r.grant.priority},
            {"locked", r.grant.locked},
            {"core", r.grant.core < 0 ? Json(nullptr) : Json(r.grant.core)},
            {"page_faults", r.grant.page_faults},
            {"why_not", r.grant.why_not}}},
          {"stands_in_the_way", findings}};
}

}  // namespace kt
