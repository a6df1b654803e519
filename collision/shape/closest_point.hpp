#pragma once
// Closest point of a triangle to a point, closest points of two segments.
#include <array>

#include "core/base/types.hpp"

namespace kt {

/// Which part of the triangle is closest: its face, an edge (index of the first vertex) or a vertex.
struct ClosestPoint {
  Vec3 bary = Vec3::Zero();   ///< weights, each >= 0, sum 1
  Vec3 point = Vec3::Zero();  ///< [m]
  double distance_sq = 0;     ///< [m^2]
  enum class Feature { face, edge, vertex } feature = Feature::face;
  int feature_index = 0;  ///< edge i joins vertices i and (i+1)%3; vertex i
};

/// Closest point on triangle abc to p. Degenerate triangles fall back to their edges and vertices.
ClosestPoint closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

/// Parameters in [0, 1] of the closest points of the segments a0 a1 and b0 b1.
std::array<double, 2> closest_parameters(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) noexcept;

}  // namespace kt
