#include "haptics/session/indentation.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace kt {
namespace {

/// Where the line p + s d meets a triangle from behind: s (Moeller and Trumbore 1997). A hair beyond its edges counts,
/// so that no line slips through between two triangles.
std::optional<double> meet(const Vec3& p, const Vec3& d, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double kHair = 1e-9;  // of the triangle
  const Vec3 ab = b - a, ac = c - a, h = d.cross(ac);
  const double volume = ab.dot(h);  // < 0 where d leaves through the outside: -(ab x ac) . d
  if (!(volume < 0)) return {};
  const Vec3 from = p - a, q = from.cross(ab);
  const double u = from.dot(h) / volume, v = d.dot(q) / volume;
  if (u < -kHair || v < -kHair || u + v > 1 + kHair) return {};
  return ac.dot(q) / volume;
}

}  // namespace

Indentation::Indentation(const std::vector<Triangle>& triangles, const VectorX& x)
    : triangles_(triangles), x_(x), index_(make_triangle_index("refit_bvh")), near_(triangles.size()) {
  index_->build(triangles, x);
  index_->refit(x, x);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Triangle& t : triangles)
    for (const int i : t) {
      low = low.cwiseMin(node(x, i));
      high = high.cwiseMax(node(x, i));
    }
  if (!triangles.empty()) size_ = (high - low).norm();
}

double Indentation::at(const Vec3& place, const Vec3& normal) const {
  double nearest = std::numeric_limits<double>::quiet_NaN();
  if (!(size_ > 0) || normal.squaredNorm() < 0.5) return nearest;
  for (double reach = size_ / 512; reach < 2 * size_; reach *= 2) {  // few triangles of a scan have to be looked at
    const ToolSweep line(place - reach * normal, place + reach * normal);
    const int count = index_->candidates(line, 0, near_);
    for (int k = 0; k < count; ++k) {
      const Triangle& t = triangles_[near_[k]];
      const auto s = meet(place, normal, node(x_, t[0]), node(x_, t[1]), node(x_, t[2]));
      if (s && std::abs(*s) <= reach && !(std::abs(*s) >= std::abs(nearest))) nearest = *s;
    }
    if (std::isfinite(nearest)) return nearest;
  }
  return nearest;
}

}  // namespace kt
