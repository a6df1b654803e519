#include "haptics/session/real_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numbers.hpp"
#include "core/base/percentile.hpp"
#include "haptics/cells/mesh_cures.hpp"

namespace kt {
namespace {

constexpr double kRoom = 0.8;     // of the time that is there: above it, the next busy moment is late
constexpr double kCrowded = 0.6;  // of the time that is there: what takes no more is not why refreshes are missing
constexpr double kLess = 0.9;     // of a rate that is not kept: the next one to try, at most
// Of the refreshes that were asked for: with less, patches and models are older than those that the figures are of.
constexpr double kReached = 0.95;

/// Without the first, which sets the run up.
double median(const std::vector<double>& ms) {
  return percentile(ms.size() > 1 ? std::vector<double>(ms.begin() + 1, ms.end()) : ms, 0.5);
}

/// Where other programs hold the processor, its time says more than the clock's; with several threads the clock's is
/// less.
double share_of_clock(const RefreshRun& refresh, double clock_ms) {
  if (refresh.cpu_ms.size() < 2 || !(clock_ms > 0)) return 1;
  return std::min(1.0, median(refresh.cpu_ms) / clock_ms);
}

/// A reducer whose force is known to be off by more is no cure: it is worse than what it cures.
constexpr double kMostError = 0.15;

/// Least error of the force that is expected of a reducer, of all its local models; NaN: not known.
double expected_error(std::span<const ReducerCandidate> candidates, const std::string& reducer) {
  double least = std::numeric_limits<double>::quiet_NaN();
  for (const ReducerCandidate& c : candidates)
    if (c.reducer == reducer && std::isfinite(c.force_error)) least = std::fmin(least, c.force_error);
  return least;
}

/// A change of reducer, where its error is known and small; a condensed body, which is none to speak of, also where it
/// is not known.
void add_reducer(const MeasuredPace& pace, const std::string& reducer, std::vector<Cure>& out) {
  const double error = expected_error(pace.candidates, reducer);
  if (std::isnan(error) ? reducer != "condensed" : error > kMostError) return;
  out.push_back(
      set_to("local.reducer", reducer,
             std::isnan(error) ? "" : told("force of the local model off by ", in_percent(error), " or more")));
}

/// Of mesh tools with many triangles, first of all.
std::vector<Cure> smaller_tools(const Scene& scene, const PaceLimits& limits) {
  std::vector<Cure> out;
  const SceneTool* const tools[] = {&scene.tool, scene.second_tool ? &*scene.second_tool : nullptr};
  for (std::size_t k = 0; k < 2; ++k)
    if (tools[k] && tools[k]->shape == "mesh" && limits.tool_triangles[k] >= kManyToolTriangles)
      out.push_back(fewer_tool_triangles(k == 0 ? "tool" : "second_tool", limits.tool_triangles[k]));
  return out;
}

std::vector<Cure> cures_of_tick(const Scene& scene, const MeasuredPace& pace, const PaceLimits& limits) {
  std::vector<Cure> out = smaller_tools(scene, limits);
  if (pace.reducer != "condensed" && pace.reducer != "wall")
    add_reducer(pace, "condensed", out);
  else if (pace.reducer == "wall" && scene.local.rings > 1)
    out.push_back(set_to("local.rings", "1"));
  else if (limits.coarser)
    out.push_back(advise("take a coarser mesh under the tool"));
  out.push_back(advise("move the tool more slowly"));
  return out;
}

std::vector<Cure> cures_of_refresh(const Scene& scene, const MeasuredPace& pace, const RealTime& r,
                                   const PaceLimits& limits) {
  std::vector<Cure> out = smaller_tools(scene, limits);
  if (r.is_crowded) {
    out = {advise("close what runs beside it")};
  } else if (r.slow_part == "reduce" || r.slow_part == "prepare" || r.slow_part == "certify") {
    if (pace.reducer == "krylov" || pace.reducer == "modal" || pace.reducer == "full")
      add_reducer(pace, "condensed", out);
    else if (pace.reducer == "condensed")
      add_reducer(pace, "wall", out);
  } else if (r.slow_part == "refine") {
    constexpr double kRoomFor = 1;  // contact radii: cells of half as many nodes are up to twice as large
    if (percentile(pace.refresh.fineness, 0.9) <= kRoomFor)
      out.push_back(set_to("local.refine_nodes", text(std::max(100, scene.local.refine_nodes / 2))));
  } else if (limits.linear_elements && scene.object.model.type == "fem" && scene.object.model.element == "tet10") {
    out.push_back(set_to("object.model.element", scene.object.body == "lattice" ? "auto" : "tet4"));
  }
  // The median fits more than what was reached, or than is asked for already, where single refreshes are slow.
  const double reached = r.lags ? r.refresh_hz : r.wanted_hz;
  const double rate = std::floor(std::min({1e3 * kRoom / r.refresh_ms, reached, kLess * r.wanted_hz}));
  if (rate >= 5)
    out.push_back(
        {"global.rate_hz", text(rate), told("set global.rate_hz to ", rate, " and move the tool more slowly")});
  else if (limits.coarser && !r.is_crowded)
    out.push_back(coarser_cells(scene));
  else if (!r.is_crowded)
    out.push_back(advise("take a wider tool with a coarser mesh (this one is as coarse as the contact bears)"));
  return out;
}

}  // namespace

const char* name_of(Keeps keeps) { return keeps == Keeps::yes ? "yes" : keeps == Keeps::no ? "no" : "just about"; }

RealTime judge_real_time(const Scene& scene, const SessionResult& result, const PaceLimits& limits) {
  return judge_real_time(scene,
                         {.seconds = static_cast<double>(result.tools[0].frames.size()) / scene.local.rate_hz,
                          .tick_us = percentile(result.step_us, 0.99),
                          .refreshes = result.refreshes.size(),
                          .wanted_hz = scene.global.rate_hz,
                          .refresh = result.refresh,
                          .reducer = result.reducer,
                          .is_against_clock = !result.lateness_us.empty(),
                          .candidates = result.reducer_candidates},
                         limits);
}

RealTime judge_real_time(const Scene& scene, const MeasuredPace& pace, const PaceLimits& limits) {
  RealTime out;
  const double period_ms = 1e3 / scene.local.rate_hz, tick_ms = 1e-3 * pace.tick_us;
  const double clock_ms = median(pace.refresh.global_ms) + median(pace.refresh.refresh_ms);
  const double share = share_of_clock(pace.refresh, clock_ms), step_ms = share * median(pace.refresh.global_ms);
  out.budget_ms = 1e3 / pace.wanted_hz;
  out.refresh_ms = share * clock_ms;
  out.refresh_hz = pace.seconds > 0 ? static_cast<double>(pace.refreshes) / pace.seconds : 0;
  out.tick_share = tick_ms / period_ms;
  const double slow_share = out.refresh_share = out.refresh_ms / out.budget_ms;

  out.slow_part = "global step";
  out.part_ms = step_ms;
  for (const auto& [part, ms] : pace.refresh.parts_ms)
    if (const double its = share * median(ms); its > out.part_ms) {
      out.slow_part = part;
      out.part_ms = its;
    }
  const bool is_timed = pace.is_against_clock || scene.link.charge_refreshes != "none";
  out.wanted_hz = pace.wanted_hz;
  out.lags = is_timed && out.refresh_hz < kReached * out.wanted_hz;
  out.is_crowded = out.lags && pace.is_against_clock && slow_share <= kCrowded && out.tick_share <= kRoom;
  const bool tick_is_worse = !out.lags && out.tick_share > slow_share;
  if (tick_is_worse) {
    out.slow_part = "haptic tick";
    out.part_ms = tick_ms;
  }

  const double worst = std::max(out.tick_share, slow_share);
  const bool early = out.refresh_ms * out.refresh_hz > 1e3;  // the extra ones do not fit
  out.keeps = worst > 1 || out.lags ? Keeps::no : worst > kRoom || early ? Keeps::just_about : Keeps::yes;
  if (out.keeps == Keeps::yes) return out;
  // The only one that is timed set the body up; what came later did not get here.
  if (scene.link.type == "network" && out.lags && (pace.refreshes <= 1 || slow_share <= kRoom)) {
    out.slow_part = "link";
    out.is_crowded = false;
    out.cures = {advise("let the body's local models through (docs/network.md: ports, firewalls, the line's rate)")};
    return out;
  }
  out.cures = tick_is_worse ? cures_of_tick(scene, pace, limits) : cures_of_refresh(scene, pace, out, limits);
  return out;
}

std::string RealTime::why() const {
  const std::string late = lags ? kt::told(refresh_hz, " of ", wanted_hz, " refreshes a second") : std::string();
  if (slow_part == "link") return late + " came over the link";
  const std::string part =
      slow_part == "haptic tick"
          ? kt::told("a haptic tick takes ", in_unit(1e-3 * part_ms, "s"), ", ", in_percent(tick_share),
                     " of its period, a refresh ", in_percent(refresh_share), " of its")
          : kt::told("a refresh takes ", refresh_ms, " ms of ", budget_ms, ", ", in_percent(refresh_share), " (",
                     is_crowded ? "other programs hold the processor" : kt::told(slow_part, " ", part_ms),
                     "), a haptic tick ", in_percent(tick_share), " of its period");
  return lags ? late + ", " + part : part;
}

std::string RealTime::told() const {
  const std::string out = text(name_of(keeps), ": ", why());
  return cures.empty() ? out : out + "; " + cure();
}

}  // namespace kt
