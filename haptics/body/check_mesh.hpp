#pragma once
// A mesh that somebody made in memory: what readers of files see to, seen to.
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Throws InputError for a coordinate that is not finite, an index that is out of range, a mesh without triangles and
/// tetrahedra, and a tetrahedron without volume. Tetrahedra get a positive volume; without triangles the surface is
/// their boundary, and triangles of it get their outside outside.
/// @param name   for messages      @param notes  what was turned
void check_and_orient(Mesh& mesh, const std::string& name, std::vector<std::string>* notes = nullptr);

}  // namespace kt
