#pragma once
// Boxes around motions, in double precision: what every broad phase must agree on to name the same triangles. Minimum,
// maximum and comparison are exact, so the answer does not depend on who asks or in which order.
#include <limits>

#include "collision/shape/contact.hpp"

namespace kt {

struct Box {
  Vec3 low, high;
  bool operator==(const Box&) const = default;
};

/// No box is apart from this one.
inline Box everywhere() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)};
}

/// Encloses a triangle at both ends of the step. A vertex that is not finite is everywhere: a minimum would drop it,
/// and the triangle would be looked for where its other vertices are.
inline Box swept_box(const Triangle& triangle, const VectorX& x_t0, const VectorX& x_t1) noexcept {
  Box box{node(x_t0, triangle[0]), node(x_t0, triangle[0])};
  double zero = 0;  // NaN once a coordinate is not finite
  for (const int i : triangle) {
    const Vec3 a = node(x_t0, i), b = node(x_t1, i);
    box.low = box.low.cwiseMin(a).cwiseMin(b);
    box.high = box.high.cwiseMax(a).cwiseMax(b);
    zero += 0 * a.sum() + 0 * b.sum();
  }
  return zero == 0 ? box : everywhere();
}

/// Encloses the path of the tool, grown by `margin` [m] on every side. A path that is not finite is everywhere.
inline Box path_box(const ToolSweep& sweep, double margin) noexcept {
  if (!sweep.x_t0.allFinite() || !sweep.x_t1.allFinite()) return everywhere();
  return {sweep.x_t0.cwiseMin(sweep.x_t1).array() - margin, sweep.x_t0.cwiseMax(sweep.x_t1).array() + margin};
}

/// Whether a plane across an axis separates them; touching boxes are not apart, and a NaN is never apart.
inline bool is_apart(const Box& a, const Box& b) noexcept {
  return (a.low.array() > b.high.array()).any() || (a.high.array() < b.low.array()).any();
}

}  // namespace kt
