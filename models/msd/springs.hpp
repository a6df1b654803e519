#pragma once
// From a mesh to a network of springs and lumped masses.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct Spring {
  int a = 0, b = 0;
  double rest_length = 0;  ///< [m]
  double stiffness = 0;    ///< [N/m]
  double damper = 0;       ///< [N s/m]
};

/// One spring per edge of the tetrahedra (or, without tetrahedra, of the triangles), ascending by (a, b); stiffness and
/// damper are left 0. Throws InputError for an edge of zero length.
std::vector<Spring> make_springs(const Mesh& mesh);

/// Multiplies each spring's stiffness by the mean factor of the elements around it, weighted by their volumes (areas).
/// @param factors  of the tetrahedra, or of the triangles of a mesh without; empty: nothing changes
void stiffen(const Mesh& mesh, const std::vector<double>& factors, std::vector<Spring>& springs);

/// Lumped node masses [kg], (n): a quarter of each tetrahedron, or a third of each triangle times `thickness` [m].
/// @param share  of each tetrahedron, how much of it is material; empty: all
VectorX lumped_masses(const Mesh& mesh, double density, double thickness, const std::vector<double>& share = {});

/// A surface and `count` layers of nodes below it, `thickness` [m] apart in all, offset against the surface normals and
/// joined by prisms split into tetrahedra: the layered bodies of the field's MSD models. Surface nodes come first and
/// keep their numbers. Throws InputError when the surface is too curved or too thin for the thickness.
Mesh add_inner_layers(const Mesh& surface, int count, double thickness);

}  // namespace kt
