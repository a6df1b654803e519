#include "self_contact/barrier.hpp"

#include <cmath>
#include <limits>

namespace kt {

double Barrier::energy(double d) const noexcept {
  if (d >= reach) return 0;
  if (d <= 0) return std::numeric_limits<double>::infinity();
  const double inside = d - reach;
  return -stiffness * inside * inside * std::log(d / reach);
}

double Barrier::slope(double d) const noexcept {
  if (d >= reach) return 0;
  if (d <= 0) return -std::numeric_limits<double>::infinity();
  const double inside = d - reach;
  return -stiffness * inside * (2 * std::log(d / reach) + inside / d);
}

double Barrier::bend(double d) const noexcept {
  if (d >= reach) return 0;
  if (d <= 0) return std::numeric_limits<double>::infinity();
  const double inside = d - reach;
  return -stiffness * (2 * std::log(d / reach) + 4 * inside / d - inside * inside / (d * d));
}

}  // namespace kt
