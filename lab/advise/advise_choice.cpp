// The choosing alone: numbers in, one answer out.
#include <algorithm>
#include <cmath>

#include "lab/advise/advise.hpp"

namespace kt {

std::pair<Limit, double> worst_limit(const Candidate& c, double tolerance) {
  std::pair<Limit, double> worst{Limit::slow_load, c.slow_load};
  if (c.tick_load > worst.second) worst = {Limit::tick_load, c.tick_load};
  if (c.error / tolerance > worst.second) worst = {Limit::error, c.error / tolerance};
  return worst;
}

Choice choose(std::span<const Candidate> candidates, double tolerance) {
  int best = -1, nearest = -1;
  const auto cost = [&](int i) { return std::pair(candidates[i].cost, candidates[i].error); };
  const auto by = [&](int i) { return worst_limit(candidates[i], tolerance).second; };
  const auto miss = [&](int i) { return std::pair(!is_real_time(candidates[i]), by(i)); };
  for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
    if (!std::isfinite(candidates[i].error) || !std::isfinite(candidates[i].cost)) continue;
    if (by(i) <= 1 && (best < 0 || cost(i) < cost(best))) best = i;
    if (nearest < 0 || miss(i) < miss(nearest)) nearest = i;
  }
  if (best >= 0 || nearest < 0) return {best, Limit::none};
  return {nearest, worst_limit(candidates[nearest], tolerance).first};
}

Candidate candidate_of(const AdviceBody& body) {
  constexpr double kSlowest = 100;  // [ms] between refreshes at 10 Hz, the lowest rate that is tried
  return {body.error, body.refresh_ms, body.refresh_ms / kSlowest, 0};
}

Candidate candidate_of(const AdviceRow& row, double local_rate_hz) {
  // Early refreshes come on top of the rate: the slow side must have time for them too.
  const double refreshes = std::max(row.rate_hz, row.refreshes_per_second);
  return {row.error, row.core_share, 1e-3 * (row.global_ms + row.refresh_ms) * refreshes,
          1e-6 * row.tick_us * local_rate_hz};
}

}  // namespace kt
