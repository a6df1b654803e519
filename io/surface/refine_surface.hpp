#pragma once
// Splits the triangles of a surface, everywhere or near a place: the same shape, finer.
#include "core/body/mesh.hpp"

namespace kt {

/// Edge length that is wanted near a place; it grows with the distance from it.
struct SurfaceSize {
  Vec3 centre = Vec3::Zero();
  double radius = 0;    ///< of the finest part [m]
  double edge = 0;      ///< in it [m], > 0
  double growth = 0.4;  ///< of the edge, per metre beyond the radius [-]
};

/// Halves edges, the longest first, until none is longer than wanted where its middle lies. New nodes come after the
/// old ones; flat triangles stay flat, so the body does not change. `surface` has no tetrahedra.
/// @throws RunError when that takes more than `max_nodes`
Mesh refine_surface(Mesh surface, const SurfaceSize& size, int max_nodes);

}  // namespace kt
