// The choosing alone: numbers in, one answer out.
#include <algorithm>
#include <cmath>

#include "haptics/advise.hpp"

namespace kt {

std::pair<Limit, double> worst_limit(const Candidate& c, double tolerance) {
  std::pair<Limit, double> worst{Limit::error, c.error / tolerance};
  if (c.slow_load > worst.second) worst = {Limit::slow_load, c.slow_load};
  if (c.tick_load > worst.second) worst = {Limit::tick_load, c.tick_load};
  return worst;
}

Choice choose(std::span<const Candidate> candidates, double tolerance) {
  Choice best, nearest;
  for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
    const Candidate& c = candidates[i];
    if (!c.measured || !std::isfinite(c.error) || !std::isfinite(c.cost)) continue;
    const auto [limit, by] = worst_limit(c, tolerance);
    if (by > 1) {
      if (nearest.index < 0 || by < nearest.by) nearest = {i, limit, by};
      continue;
    }
    const bool better = best.index < 0 || c.cost < candidates[best.index].cost ||
                        (c.cost == candidates[best.index].cost && c.error < candidates[best.index].error);
    if (better) best.index = i;
  }
  return best.index >= 0 ? best : nearest;
}

Candidate candidate_of(const AdviceBody& body) {
  constexpr double kSlowest = 100;  // [ms] between global steps at 10 Hz, the lowest rate that is tried
  return {body.error, body.global_ms, body.global_ms / kSlowest, 0, body.measured};
}

Candidate candidate_of(const AdviceRow& row, double local_rate_hz) {
  // Early refreshes come on top of the rate: the slow side must have time for them too.
  const double refreshes = std::max(row.rate_hz, row.refreshes_per_second);
  return {row.error, row.core_share, 1e-3 * (row.global_ms + row.refresh_ms) * refreshes,
          1e-6 * row.step_us_p99 * local_rate_hz, row.measured};
}

}  // namespace kt
