#pragma once
// Nodes that lie in one place, or nearly: found, joined, and the tolerance that would join them.
#include <optional>

#include "core/body/mesh.hpp"

namespace kt {

/// Joins every node with the first one that lies at most `tolerance` away, by giving triangles and tetrahedra that
/// node's number; no node moves. Those that nothing uses now stay. Nodes that are not finite are left alone.
/// @param tolerance  [mesh unit], >= 0; 0: equal coordinates        @returns how many were joined to another
int join_nodes(Mesh& mesh, double tolerance);

/// The rounding of the coordinates of a mesh [mesh unit]: two nodes that are nearer than this are one.
double rounding_of(const Mesh& mesh);

/// Nodes at open edges that lie near another such node, but not in the same place.
struct NearNodes {
  int count = 0;         ///< nodes that would be joined
  double distance = 0;   ///< the largest between such two [mesh unit]
  double tolerance = 0;  ///< twice that, rounded to one digit: what join_nodes needs
  int open_edges_before = 0, open_edges_after = 0;
};

/// What joining would do, when it would close open edges: looked for up to a tenth of the mean length of an open edge.
std::optional<NearNodes> find_near_nodes(const Mesh& surface);

}  // namespace kt
