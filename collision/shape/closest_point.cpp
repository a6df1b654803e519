// Vertex regions first (Ericson, Real-Time Collision Detection, section 5.1.5), then the face, then the edges.
//
// Differs from Ericson: the face is solved in the orthogonal frame of the longest edge and its height, not by ratios of
// areas. Those cancel in slivers and put the foot far away along the triangle; here the distance is right to a few
// units of rounding of the largest coordinate, whatever the shape. A triangle without height has no face.
#include "collision/shape/closest_point.hpp"

#include <algorithm>
#include <limits>

namespace kt {
namespace {

using Feature = ClosestPoint::Feature;

ClosestPoint make(const Vec3& p, const Vec3 (&v)[3], const Vec3& bary, Feature feature, int index) noexcept {
  ClosestPoint out;
  out.bary = bary;
  out.point = bary[0] * v[0] + bary[1] * v[1] + bary[2] * v[2];
  out.distance_sq = (p - out.point).squaredNorm();
  out.feature = feature;
  out.feature_index = index;
  return out;
}

/// Weights of p's foot in the plane of the triangle; negative ones outside, or no height.
Vec3 weights_in_plane(const Vec3& p, const Vec3 (&v)[3], const double (&length_sq)[3]) noexcept {
  constexpr double kNoHeight = 1e-30;  // squared, of the longest edge: then it is rounding, and the edges are as near
  const auto i = static_cast<int>(std::max_element(length_sq, length_sq + 3) - length_sq);
  const int k = (i + 1) % 3, m = (i + 2) % 3;
  const Vec3 base = v[k] - v[i], side = v[m] - v[i], q = p - v[i];
  const double foot = base.dot(side) / length_sq[i];
  const Vec3 height = side - foot * base;
  const double height_sq = height.squaredNorm();
  Vec3 bary = Vec3::Constant(-1);
  if (!(height_sq > kNoHeight * length_sq[i])) return bary;
  const double along = base.dot(q) / length_sq[i];
  bary[m] = height.dot(q - along * base) / height_sq;
  bary[k] = along - foot * bary[m];
  bary[i] = 1 - bary[m] - bary[k];
  return bary;
}

/// An order of points that depends on nothing else: triangles that share an edge evaluate it alike, bit for bit, from
/// whichever end they list it.
bool is_before(const Vec3& a, const Vec3& b) noexcept {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// On the edges that the foot lies outside of: those opposite a weight that is not positive.
ClosestPoint closest_on_edges(const Vec3& p, const Vec3 (&v)[3], const double (&length_sq)[3],
                              const Vec3& bary_in_plane) noexcept {
  int from = 0, to = 1;
  double best_s = 0, best_sq = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3;
    if (bary_in_plane[(i + 2) % 3] > 0) continue;
    const int low = is_before(v[k], v[i]) ? k : i, high = low == i ? k : i;
    const Vec3 edge = v[high] - v[low], q = p - v[low];
    const double s = length_sq[i] > 0 ? std::clamp(edge.dot(q) / length_sq[i], 0.0, 1.0) : 0.0;
    if (const double d = (q - s * edge).squaredNorm(); d < best_sq) {
      from = low;
      to = high;
      best_s = s;
      best_sq = d;
    }
  }
  Vec3 bary = Vec3::Zero();
  bary[from] = 1 - best_s;
  bary[to] = best_s;
  if (best_s > 0 && best_s < 1) return make(p, v, bary, Feature::edge, to == (from + 1) % 3 ? from : to);
  return make(p, v, bary, Feature::vertex, best_s < 1 ? from : to);
}

/// Of the point nearest to p on the segment a b.
double parameter_on(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length_sq = along.squaredNorm();
  return length_sq > 0 ? std::clamp(along.dot(p - a) / length_sq, 0.0, 1.0) : 0.0;
}

}  // namespace

ClosestPoint closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 v[3] = {a, b, c};
  const Vec3 ab = b - a, bc = c - b, ca = a - c, ap = p - a, bp = p - b, cp = p - c;
  const double ab_ap = ab.dot(ap), bc_bp = bc.dot(bp), ca_cp = ca.dot(cp);
  if (ab_ap <= 0 && ca.dot(ap) >= 0) return make(p, v, Vec3::UnitX(), Feature::vertex, 0);
  if (bc_bp <= 0 && ab.dot(bp) >= 0) return make(p, v, Vec3::UnitY(), Feature::vertex, 1);
  if (ca_cp <= 0 && bc.dot(cp) >= 0) return make(p, v, Vec3::UnitZ(), Feature::vertex, 2);
  const double length_sq[3] = {ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()};
  const Vec3 bary = weights_in_plane(p, v, length_sq);
  if (bary[0] > 0 && bary[1] > 0 && bary[2] > 0) return make(p, v, bary, Feature::face, 0);
  return closest_on_edges(p, v, length_sq, bary);
}

std::array<double, 2> closest_parameters(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) noexcept {
  std::array<double, 2> best{};
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double s, double t) {
    const double d = (a0 + s * (a1 - a0) - b0 - t * (b1 - b0)).squaredNorm();
    if (d < least) {
      least = d;
      best = {s, t};
    }
  };
  const Vec3 u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm();
  const double cross_sq = u.cross(v).squaredNorm();  // uu vv - uv^2, without the cancellation
  if (cross_sq > 0) {
    const double s = (uv * v.dot(w) - vv * u.dot(w)) / cross_sq, t = (uu * v.dot(w) - uv * u.dot(w)) / cross_sq;
    if (s > 0 && s < 1 && t > 0 && t < 1) consider(s, t);
  }
  consider(0, parameter_on(a0, b0, b1));
  consider(1, parameter_on(a1, b0, b1));
  consider(parameter_on(b0, a0, a1), 0);
  consider(parameter_on(b1, a0, a1), 1);
  return best;
}

}  // namespace kt
