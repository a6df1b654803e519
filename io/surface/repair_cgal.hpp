#pragma once
// The parts of the repair that need CGAL. Internal to io/.
#include "io/surface/mesh_repair.hpp"

namespace kt {

/// Closes every hole of at most `max_edges` edges with triangles over its own border nodes; returns how many. The
/// surface must be manifold and consistently oriented.
int fill_holes_cgal(Mesh& surface, int max_edges);

/// alpha_wrap_3 with options already made positive.
Mesh alpha_wrap_cgal(const Mesh& surface, double alpha, double offset);

/// Largest distance of points sampled on `from` to the surface `to`; `spacing` [unit] between samples.
double sampled_distance_cgal(const Mesh& from, const Mesh& to, double spacing);

}  // namespace kt
