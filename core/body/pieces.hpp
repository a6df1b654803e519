#pragma once
// Which parts of a body hang together: pieces, what holds them, and nodes that lie in one place without being shared.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Number of the piece that each node belongs to, in order of their first node; -1: nothing uses it. Pieces share no
/// node: of tetrahedra, or of triangles where there are none.                                        (n)
std::vector<int> pieces_of(const Mesh& body, int& count);

/// Three of the nodes span an area, so that what they hold cannot turn about them.
/// @param size  of the body [m]
bool holds_still(const Mesh& body, const std::vector<int>& nodes, double size);

/// Groups of nodes within `tolerance` [m] of their group's first one, each of two or more, ascending. Of a body's used
/// nodes, a seam that was not joined.
std::vector<std::vector<int>> coincident_nodes(const Mesh& body, double tolerance);

}  // namespace kt
