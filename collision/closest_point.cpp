// Voronoi regions of a triangle (Ericson, Real-Time Collision Detection, section 5.1.5). A degenerate triangle has no
// face region; the nearest of its edges then decides.
#include "collision/closest_point.hpp"

#include <algorithm>
#include <limits>

namespace kt {
namespace {

using Feature = ClosestPoint::Feature;

ClosestPoint make(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& bary, Feature feature,
                  int index) noexcept {
  ClosestPoint out;
  out.bary = bary;
  out.point = bary[0] * a + bary[1] * b + bary[2] * c;
  out.distance_sq = (p - out.point).squaredNorm();
  out.feature = feature;
  out.feature_index = index;
  return out;
}

ClosestPoint closest_on_edges(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 corners[3] = {a, b, c};
  ClosestPoint best;
  best.distance_sq = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3;
    const Vec3 edge = corners[k] - corners[i];
    const double length_sq = edge.squaredNorm();
    const double s = length_sq > 0 ? std::clamp(edge.dot(p - corners[i]) / length_sq, 0.0, 1.0) : 0.0;
    Vec3 bary = Vec3::Zero();
    bary[i] = 1 - s;
    bary[k] = s;
    const bool inner = s > 0 && s < 1;
    const ClosestPoint here = make(p, a, b, c, bary, inner ? Feature::edge : Feature::vertex, s < 1 ? i : k);
    if (here.distance_sq < best.distance_sq) best = here;
  }
  return best;
}

}  // namespace

ClosestPoint closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return make(p, a, b, c, {1, 0, 0}, Feature::vertex, 0);
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return make(p, a, b, c, {0, 1, 0}, Feature::vertex, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
    const double s = d1 / (d1 - d3);
    return make(p, a, b, c, {1 - s, s, 0}, Feature::edge, 0);
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return make(p, a, b, c, {0, 0, 1}, Feature::vertex, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
    const double s = d2 / (d2 - d6);
    return make(p, a, b, c, {1 - s, 0, s}, Feature::edge, 2);
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return make(p, a, b, c, {0, 1 - s, s}, Feature::edge, 1);
  }
  const double sum = va + vb + vc;
  // |ab x ac|^2 up to rounding: when it drowns in its own cancellation, the triangle has no inside.
  if (!(sum > 1e-14 * ab.squaredNorm() * ac.squaredNorm())) return closest_on_edges(p, a, b, c);
  const double v = vb / sum, w = vc / sum;
  return make(p, a, b, c, {1 - v - w, v, w}, Feature::face, 0);
}

}  // namespace kt
