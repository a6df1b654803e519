#pragma once
// The holes of a surface, as loops of edges, from OpenMesh's half-edge structure.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct BorderLoop {
  std::vector<int> nodes;      ///< in order around the hole
  double length = 0;           ///< of its edges [mesh unit]
  Vec3 centre = Vec3::Zero();  ///< mean of the nodes
};

/// Loops of open edges, in order of their first triangle. Triangles that a half-edge structure cannot hold (repeated
/// nodes, third triangles of an edge, opposite orientation) are left out first.
/// Defined in border_loops_openmesh.cpp: call only when KT_WITH_OPENMESH.
std::vector<BorderLoop> find_border_loops(const Mesh& mesh);

}  // namespace kt
