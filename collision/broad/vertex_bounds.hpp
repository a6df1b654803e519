#pragma once
// Boxes around the motions of vertices, in double precision and as floats relative to the place of the build.
//
// The floats need no outward rounding: both sides of every comparison, box and path, are made relative and rounded in
// the same way, which keeps their order, so what meets in double precision meets here. What meets here is sifted with
// the exact box, which the three vertices' boxes give. A bound is six numbers, the low corner and the negated high one:
// then a union is six minima.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "collision/shape/swept_box.hpp"

namespace kt {

constexpr int kBoundSides = 6;

/// Low corner, negated high corner; two more so that they fill registers.
struct alignas(16) Bound {
  std::array<float, 8> side{};
};

inline Bound smaller(const Bound& a, const Bound& b) noexcept {
  Bound out;
  for (int s = 0; s < 8; ++s) out.side[s] = a.side[s] < b.side[s] ? a.side[s] : b.side[s];
  return out;
}

class VertexBounds {
 public:
  /// Of vertices that rest at x (3p). May allocate.
  void adopt(const VectorX& x) {
    const auto n = static_cast<std::size_t>(x.size() / 3);
    exact_.assign(n, {});
    rounded_.assign(n, {});
    origin_.setZero();
    for (std::size_t v = 0; v < n; ++v)
      if (node(x, static_cast<int>(v)).allFinite()) {
        origin_ = node(x, static_cast<int>(v));
        break;
      }
  }

  int size() const noexcept { return static_cast<int>(exact_.size()); }

  void fit(const VectorX& x_t0, const VectorX& x_t1) noexcept {
    for (int v = 0; v < size(); ++v) fit(v, x_t0, x_t1);
  }

  /// A vertex that is not finite is everywhere.
  void fit(int v, const VectorX& x_t0, const VectorX& x_t1) noexcept {
    const double* const a = x_t0.data() + 3 * v;
    const double* const b = x_t1.data() + 3 * v;
    Box& box = exact_[v];
    double zero = 0;  // NaN once a coordinate is not finite
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(a[k], b[k]);
      box.high[k] = std::max(a[k], b[k]);
      zero += 0 * a[k] + 0 * b[k];
    }
    if (!(zero == 0)) box = everywhere();
    for (int k = 0; k < 3; ++k) {
      rounded_[v].side[k] = rounded(box.low[k] - origin_[k]);
      rounded_[v].side[k + 3] = rounded(origin_[k] - box.high[k]);
    }
  }

  const Bound& of(int vertex) const noexcept { return rounded_[vertex]; }
  Bound of(const Triangle& t) const noexcept { return smaller(smaller(of(t[0]), of(t[1])), of(t[2])); }

  Box exact(const Triangle& t) const noexcept {
    const Box &a = exact_[t[0]], &b = exact_[t[1]], &c = exact_[t[2]];
    return {a.low.cwiseMin(b.low).cwiseMin(c.low), a.high.cwiseMax(b.high).cwiseMax(c.high)};
  }

  /// A bound that meets the path has no side beyond these.
  Bound farthest_sides(const Box& path) const noexcept {
    Bound out;
    for (int k = 0; k < 3; ++k) {
      out.side[k] = rounded(path.high[k] - origin_[k]);
      out.side[k + 3] = rounded(origin_[k] - path.low[k]);
    }
    return out;
  }

 private:
  static_assert(std::numeric_limits<float>::is_iec559, "a double too large for a float becomes infinite");

  /// Monotone: a <= b gives rounded(a) <= rounded(b), and rounded(-a) == -rounded(a).
  static float rounded(double v) noexcept { return static_cast<float>(v); }

  std::vector<Box> exact_;      // of each vertex's motion
  std::vector<Bound> rounded_;  // the same as floats
  Vec3 origin_ = Vec3::Zero();
};

}  // namespace kt
