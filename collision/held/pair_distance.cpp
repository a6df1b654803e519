#include "collision/held/pair_distance.hpp"

#include "collision/shape/closest_point.hpp"

namespace kt {

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
