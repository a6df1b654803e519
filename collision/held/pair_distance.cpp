#include "collision/held/pair_distance.hpp"

#include "collision/shape/closest_point.hpp"

namespace kt {
namespace {

/// Of the point nearest to p on the segment a b.
double parameter_on(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length_sq = along.squaredNorm();
  return length_sq > 0 ? std::clamp(along.dot(p - a) / length_sq, 0.0, 1.0) : 0.0;
}

}  // namespace

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

PairDistance pair_distance(const SurfacePair& pair, const VectorX& x) noexcept {
  const Vec3 p[4] = {node(x, pair.nodes[0]), node(x, pair.nodes[1]), node(x, pair.nodes[2]), node(x, pair.nodes[3])};
  PairDistance out;
  if (pair.kind == SurfacePair::Kind::vertex_face) {
    const Vec3 bary = closest_point_on_triangle(p[0], p[1], p[2], p[3]).bary;
    out.weight = {1, -bary[0], -bary[1], -bary[2]};
  } else {
    const auto [s, t] = closest_parameters(p[0], p[1], p[2], p[3]);
    out.weight = {1 - s, s, t - 1, -t};
  }
  // From the first node, so that far from the origin nothing is lost.
  Vec3 apart = Vec3::Zero();
  for (int i = 1; i < 4; ++i) apart += out.weight[i] * (p[i] - p[0]);
  out.distance = apart.norm();
  if (out.distance > 0) out.normal = apart / out.distance;
  return out;
}

}  // namespace kt
