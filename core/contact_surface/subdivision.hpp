#pragma once
// Smooth surfaces over triangles: each refinement splits every triangle in four and places the vertices at weighted
// means of those before. All is linear in the positions, so the weights are found once.
#include <span>
#include <vector>

#include "core/body/surface.hpp"

namespace kt {

/// The vertices of a refined surface as means of those that it was made of: vertex i has the weights weight[k] of the
/// vertices from[k], first[i] <= k < first[i+1]; their sum is 1.
struct Subdivision {
  std::vector<Triangle> triangles;  ///< those of triangle t: from 4^levels t on
  std::vector<int> first, from;
  std::vector<double> weight;
  int num_vertices() const { return static_cast<int>(first.size()) - 1; }
};

/// Loop's surface (1987), with creases as Hoppe et al. (1994): its curvature is continuous but at vertices with other
/// than six neighbours, where its normal is. It lies within the hull of the triangles, so inside a convex body. The
/// vertices are those that endless refinement leads to.
///
/// Sharp edges stay edges, and vertices where one or more than two of them meet stay where they are, as do vertices
/// with more than ten neighbours; edges of one triangle or of more than two are sharp.
/// @param sharp   per triangle: of its edges (v[i], v[i+1])
/// @param levels  >= 0
Subdivision subdivide_loop(std::span<const Triangle> triangles, int num_vertices,
                           std::span<const std::array<bool, 3>> sharp, int levels);

}  // namespace kt
