#pragma once
// Distance of a vertex from a triangle and of two edges from one another.
#include "collision/broad/surface_pairs.hpp"

namespace kt {

/// The closest points of a pair: their difference is sum_i weight[i] x_i, of length `distance` along `normal`. The
/// weights sum to zero, so the gradient of the distance by node i is weight[i] normal (the closest points are where the
/// distance is stationary or at the ends).
struct PairDistance {
  double distance = 0;  ///< [m]
  std::array<double, 4> weight{};
  Vec3 normal = Vec3::Zero();  ///< unit, from the triangle or second edge; zero at distance 0
};

/// Degenerate triangles and edges count as the edges or points that they are.
PairDistance pair_distance(const SurfacePair& pair, const VectorX& x) noexcept;

}  // namespace kt
