#pragma once
// For how long does a plane keep two moving sets of points apart? The certificate of docs/collision.md: for any
// direction n and any turn across it, one quadratic per pair of points.
#include <cmath>
#include <limits>

#include "core/base/types.hpp"

namespace kt {

/// Smallest positive root of a + b t + c t^2 with a > 0, or infinity.
inline double first_root(double a, double b, double c) noexcept {
  const double d = b * b - 4 * a * c;
  if (d < 0 || (b >= 0 && c >= 0)) return std::numeric_limits<double>::infinity();
  return b < 0 ? 2 * a / (std::sqrt(d) - b) : (b + std::sqrt(d)) / (-2 * c);
}

/// For how long all of the points `now`, moving by `change` per unit of time, stay further than `reach` from the origin
/// along n, which turns by `turn` (across n) per unit of time; 0 when they are not now. While the plane turns by s, its
/// direction n + s is at most 1 + s^2/2 long.
template <class Points>
double separated_for(const Points& now, const Points& change, int count, const Vec3& n, const Vec3& turn,
                     double reach) noexcept {
  const double turn_sq = turn.squaredNorm();
  double free = turn_sq > 0 ? 1 / std::sqrt(turn_sq) : std::numeric_limits<double>::infinity();  // 1 rad: rounding
  for (int i = 0; i < count; ++i) {
    const double apart = n.dot(now[i]) - reach;
    if (!(apart > 0)) return 0;
    const double rate = n.dot(change[i]) + turn.dot(now[i]), bend = turn.dot(change[i]) - 0.5 * reach * turn_sq;
    const double until = first_root(apart, rate, bend);
    if (until < free) free = until;
  }
  return free * (1 - 1e-15);
}

}  // namespace kt
