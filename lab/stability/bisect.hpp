#pragma once
// Where a verdict changes along a ray through a map: bisection instead of a grid.
#include <cmath>
#include <limits>

namespace kt {

/// The last place known to be inside and the first known to be outside; NaN for the one that was not found.
struct RayCrossing {
  double inside = std::numeric_limits<double>::quiet_NaN();
  double outside = std::numeric_limits<double>::quiet_NaN();
  bool is_found() const { return !std::isnan(inside) && !std::isnan(outside); }
  /// Between the two: geometric mean of positive numbers, else the middle. NaN when not found.
  double at() const {
    return inside > 0 && outside > 0 ? std::sqrt(inside) * std::sqrt(outside) : 0.5 * (inside + outside);
  }
};

struct BisectOptions {
  double tolerance = 0.005;  ///< width of the bracket: relative of a geometric one, absolute of a linear one
  bool geometric = true;     ///< halves the logarithm: for scales over decades
};

/// @param inside, outside  ends of the ray, in either order of size; both > 0 for a geometric one
/// @param is_outside       called with places on the ray, the ends first; it may record them. One crossing is assumed.
template <class IsOutside>
RayCrossing bisect(double inside, double outside, const BisectOptions& options, const IsOutside& is_outside) {
  RayCrossing out;
  if (is_outside(inside)) {
    out.outside = inside;
    return out;
  }
  out.inside = inside;
  if (!is_outside(outside)) {
    out.inside = outside;
    return out;
  }
  out.outside = outside;
  const auto width = [&] {
    return options.geometric ? std::abs(std::log(out.outside / out.inside)) : std::abs(out.outside - out.inside);
  };
  while (width() > options.tolerance) {
    const double middle =
        options.geometric ? std::sqrt(out.inside) * std::sqrt(out.outside) : 0.5 * (out.inside + out.outside);
    if (middle == out.inside || middle == out.outside) break;  // neighbouring numbers
    (is_outside(middle) ? out.outside : out.inside) = middle;
  }
  return out;
}

}  // namespace kt
