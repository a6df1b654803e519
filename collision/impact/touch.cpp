#include "collision/impact/touch.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "collision/shape/unit_vector.hpp"

namespace kt {
namespace {

using touch_times::Areas;

Vec3 at(const double (&x)[2][3], double t) noexcept {
  const auto lerp = [&](int k) { return (1 - t) * x[0][k] + t * x[1][k]; };
  return {lerp(0), lerp(1), lerp(2)};
}
Vec3 change(const double (&x)[2][3]) noexcept { return {x[1][0] - x[0][0], x[1][1] - x[0][1], x[1][2] - x[0][2]}; }

/// Weights from the areas; false where the normal vanishes.
bool weigh_by_areas(FeaturePair pair, const Areas& areas, FeatureTouch& out) noexcept {
  if (!areas.is_regular) return false;
  const double one = 1 / areas.normal;
  double share[4] = {0, 0, 0, 0};
  bool is_zero[4];
  for (int i = 0; i < areas.num; ++i) {
    is_zero[i] = std::abs(areas.now[i]) <= 4 * areas.c[i].error;
    share[i] = is_zero[i] ? 0 : std::clamp(areas.now[i] * one, 0.0, 1.0);
  }
  const auto set = [&](int point, int i, double sum) {
    out.weight[point] = share[i] / sum;
    out.is_zero[point] = is_zero[i];
  };
  if (pair == FeaturePair::vertex_face) {
    const double sum = share[0] + share[1] + share[2];
    if (!(sum > 0)) return false;
    out.weight[0] = 1;
    set(1, 2, sum), set(2, 0, sum), set(3, 1, sum);
    return true;
  }
  const double a = share[0] + share[1], b = share[2] + share[3];
  if (!(a > 0 && b > 0)) return false;
  set(0, 1, a), set(1, 0, a), set(2, 3, b), set(3, 2, b);
  return true;
}

/// Weights where the face or edges are degenerate or parallel: those of the closest points.
void weigh_by_distance(const RoundedMotion& m, double t, FeatureTouch& out) noexcept {
  const Vec3 e1 = at(m.vectors().e1, t), e2 = at(m.vectors().e2, t), d = at(m.vectors().d, t);
  const Vec3 origin = Vec3::Zero();
  if (m.pair() == FeaturePair::vertex_face) {
    const Vec3 bary = closest_point_on_triangle(d, origin, e1, e2).bary;
    out.weight[0] = 1;
    for (int i = 0; i < 3; ++i) out.weight[i + 1] = bary[i];
  } else {
    // Parallel edges touch at an end of one of them; the edges are 0 + s e1 and d + r e2.
    double best = -1;
    const auto consider = [&](const Vec3& p, const Vec3& start, const Vec3& edge, int end, bool is_of_a) {
      const double length_sq = edge.squaredNorm();
      const double w = length_sq > 0 ? std::clamp((p - start).dot(edge) / length_sq, 0.0, 1.0) : 0;
      const double distance_sq = (start + w * edge - p).squaredNorm();
      if (best >= 0 && !(distance_sq < best)) return;
      best = distance_sq;
      const double s = is_of_a ? end : w, r = is_of_a ? w : end;
      out.weight[0] = 1 - s, out.weight[1] = s, out.weight[2] = 1 - r, out.weight[3] = r;
    };
    consider(origin, d, e2, 0, true);
    consider(e1, d, e2, 1, true);
    consider(d, origin, e1, 0, false);
    consider(d + e2, origin, e1, 1, false);
  }
  for (int i = 0; i < 4; ++i) out.is_zero[i] = out.weight[i] == 0;
}

/// The common normal, from the second feature to the first before the touch; where there is none, against the motion.
Vec3 normal_at(const RoundedMotion& m, double t, bool is_regular, const FeatureTouch& touch) noexcept {
  const auto& v = m.vectors();
  const bool is_face = m.pair() == FeaturePair::vertex_face;
  const Vec3 n = is_regular ? unit_vector(at(v.e1, t).cross(at(v.e2, t))) : Vec3(Vec3::Zero());
  const bool has_normal = !n.isZero(0);
  if (has_normal) {
    const double volume = value(m.distance(), t);
    if (std::abs(volume) > m.distance().error) return (volume > 0) == is_face ? n : Vec3(-n);
  }
  // Velocity of the first relative to the second: of d - beta e1 - gamma e2, or of s e1 - r e2 - d.
  const Vec3 velocity = is_face ? Vec3(change(v.d) - touch.weight[2] * change(v.e1) - touch.weight[3] * change(v.e2))
                                : Vec3(touch.weight[1] * change(v.e1) - touch.weight[3] * change(v.e2) - change(v.d));
  if (has_normal) return velocity.dot(n) > 0 ? Vec3(-n) : n;
  const Vec3 against = -unit_vector(velocity);
  return against.isZero(0) ? Vec3(Vec3::UnitZ()) : against;
}

}  // namespace

FeatureTouch touch_at(const RoundedMotion& m, double t, const Areas& areas) noexcept {
  FeatureTouch out;
  if (!weigh_by_areas(m.pair(), areas, out)) weigh_by_distance(m, t, out);
  out.normal = normal_at(m, t, areas.is_regular, out);
  return out;
}

}  // namespace kt
