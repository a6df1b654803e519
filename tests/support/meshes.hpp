#pragma once
// Small bodies for tests, made by rule.
#include "core/body/mesh.hpp"

namespace kt {

/// The corner of a cube with edge h [m]: one tetrahedron.
Mesh one_tetrahedron(double h);

/// Flat sheet [0, nx h] x [0, ny h] at z = 0 of triangles, normal +z; node (i, j) has number j (nx+1) + i.
Mesh sheet(int nx, int ny, double h);

/// Nodes of the mesh with z below `height` [m], ascending.
std::vector<int> nodes_below(const Mesh& mesh, double height);

}  // namespace kt
