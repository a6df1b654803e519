#include "haptics/refresh/reducer_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr int kFewNodes = 300;        // up to here the whole body is a local model worth trying
constexpr double kCoarseRank = 0.03;  // motions that are others' to within this part of their length are dropped
constexpr double kAlike = 1.1;        // costs that are no more than so much larger are no reason for a larger error
constexpr double kHardlyLater = 1.5;  // more than that is worse than a less accurate one
const std::vector<double> kManyShifts{0, 20, 40, 80, 160, 400};  // [Hz]

std::string krylov_name(const std::vector<double>& shifts_hz) {
  std::string out = "krylov {";
  for (std::size_t i = 0; i < shifts_hz.size(); ++i) out += text(i ? ", " : "", shifts_hz[i]);
  return out + "} Hz";
}

ReducerCandidate make_candidate(const std::string& reducer, int rings, const std::vector<double>& shifts_hz = {},
                                double rank_tolerance = ReduceOptions().rank_tolerance) {
  ReducerCandidate out;
  out.reducer = reducer;
  out.options.rings = rings;
  out.name = reducer;
  if (reducer == "wall") out.name += text(" of ", rings, rings == 1 ? " ring" : " rings");
  if (!shifts_hz.empty()) {
    out.options.shifts_hz = shifts_hz;
    out.options.rank_tolerance = rank_tolerance;
    out.name = krylov_name(shifts_hz);
    if (rank_tolerance == kCoarseRank) out.name += ", coarse";
  }
  return out;
}

}  // namespace

std::vector<BackendInfo> reducer_names() {
  std::vector<BackendInfo> out = reducer_backends();
  out.push_back(
      {"auto", "the cheapest of these that keeps the expected force error, with refined cells', within local.tolerance",
       true, ""});
  return out;
}

ReducerCandidate make_reducer_candidate(const std::string& reducer, int rings) {
  ReducerCandidate out = make_candidate(reducer, rings);
  if (reducer == "krylov") out.name = krylov_name(out.options.shifts_hz);
  return out;
}

std::vector<ReducerCandidate> auto_candidates(int num_nodes) {
  std::vector<ReducerCandidate> out{make_candidate("condensed", 1)};
  for (int rings : {1, 2, 3}) out.push_back(make_candidate("wall", rings));
  for (const auto& shifts : {ReduceOptions().shifts_hz, {0, 60, 250}, kManyShifts})
    out.push_back(make_candidate("krylov", 1, shifts));
  // Fine meshes: many vertices in reach move nearly alike.
  out.push_back(make_candidate("krylov", 1, ReduceOptions().shifts_hz, kCoarseRank));
  if (num_nodes <= kFewNodes) out.push_back(make_candidate("full", 1));
  return out;
}

double model_tolerance(double tolerance, double cells_error) {
  constexpr double kQuarterMore = 1.25;
  const double whole = std::max(tolerance, kQuarterMore * cells_error);
  return std::sqrt(whole * whole - cells_error * cells_error);
}

double refreshes_per_interval(const ReducerCandidate& candidate) {
  constexpr double kTooStiff = 0.15;  // of the impedance at rest: a wall of 3 rings that was off by 0.17 took 41 for 26
  return !candidate.errors.empty() && candidate.errors.front() > kTooStiff ? 2 : 1;
}

const std::vector<double>& most_shifts_hz() { return kManyShifts; }

std::size_t choose_reducer(const std::vector<ReducerCandidate>& candidates, const ReducerNeeds& needs) {
  const auto share = [](double taken, double there) {
    return std::isinf(there) && std::isfinite(taken) ? 0 : taken / there;
  };
  const auto over = [&](const ReducerCandidate& c) {
    if (c.dof == 0 && std::isinf(c.tick_us)) return c.tick_us;  // it could not be made
    return std::max(share(c.tick_us, needs.budget_us),
                    share(refreshes_per_interval(c) * c.refresh_ms, needs.refresh_budget_ms));
  };
  const auto better = [&](const ReducerCandidate& a, const ReducerCandidate& b) {
    const bool a_fits = over(a) <= 1, b_fits = over(b) <= 1;
    if (a_fits != b_fits) return a_fits;
    if (!a_fits) return over(a) < over(b);
    const bool a_holds = a.force_error <= needs.tolerance, b_holds = b.force_error <= needs.tolerance;
    if (a_holds != b_holds) return a_holds;
    return a_holds ? a.cost_us < b.cost_us : a.force_error < b.force_error;
  };
  auto best = std::min_element(candidates.begin(), candidates.end(), better);
  if (over(*best) > 1 && std::isfinite(over(*best))) {
    const double most = kHardlyLater * over(*best);
    // The first that is right, as they are about as late as one another; else the least wrong.
    const auto rather = [&](const ReducerCandidate& a, const ReducerCandidate& b) {
      const bool a_holds = a.force_error <= needs.tolerance, b_holds = b.force_error <= needs.tolerance;
      if (a_holds != b_holds) return a_holds;
      return a_holds ? over(a) < over(b) : a.force_error < b.force_error;
    };
    for (auto c = candidates.begin(); c != candidates.end(); ++c)
      if (over(*c) <= most && rather(*c, *best)) best = c;
  }
  if (over(*best) <= 1 && best->force_error > needs.tolerance) {
    // One that is right and comes a little late is better than a wrong one in time (ReducerChoice::note_cost).
    const auto in_time = best;
    for (auto c = candidates.begin(); c != candidates.end(); ++c)
      if (c->tick_us <= needs.budget_us && c->force_error <= needs.tolerance && refreshes_per_interval(*c) == 1 &&
          over(*c) <= kHardlyLater && (best == in_time || over(*c) < over(*best)))
        best = c;
  }
  if (over(*best) > 1 || best->force_error > needs.tolerance)
    return static_cast<std::size_t>(best - candidates.begin());
  const double most_us = kAlike * best->cost_us;
  for (auto c = candidates.begin(); c != candidates.end(); ++c)
    if (over(*c) <= 1 && c->cost_us <= most_us && c->force_error < best->force_error) best = c;
  return static_cast<std::size_t>(best - candidates.begin());
}

double predict_refresh_us(const LocalModel& model, const ReduceOptions& options) {
  constexpr double kRest = 5000, kPerColumnSq = 0.25;    // solutions, orthonormalization
  constexpr double kPerMotionCubed = 3e-3;               // vibrations, scheme
  constexpr double kCutOut = 1000, kPerDofCubed = 2e-4;  // of nodes that are there already; dense factors
  if (model.reducer != "krylov" && model.reducer != "condensed")
    return kCutOut + kPerDofCubed * std::pow(model.dof(), 3);
  const SurfacePatch& patch = model.patch;
  const bool at_rest = model.reducer == "condensed";
  const auto reach = static_cast<double>(std::ranges::count(patch.in_reach, 1));
  const auto shifts = static_cast<double>(options.shifts_hz.size());
  const double later = at_rest ? 0 : 3 * reach + 12 * (shifts - 2) + 12 * shifts + 3 * options.echoes;
  const double rim = reach < patch.num_vertices() ? 12 : 0;
  const double columns = 3 * reach + rim + later;
  return kRest + kPerColumnSq * columns * columns + kPerMotionCubed * std::pow(model.dof(), 3);
}

double predict_rest_ms(int num_nodes, int num_tetrahedra, bool is_fem) {
  // More than in proportion: a larger body takes more iterations, and no longer fits into the cache.
  constexpr double kPerNode = 3.9e-4, kGrowth = 1.35, kPerElement = 5e-4;
  return kPerNode * std::pow(num_nodes, kGrowth) + (is_fem ? kPerElement * num_tetrahedra : 0);
}

}  // namespace kt
