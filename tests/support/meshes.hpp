#pragma once
// Small bodies for tests, made by rule.
#include "core/mesh.hpp"

namespace kt {

/// Box [0, nx h] x [0, ny h] x [0, nz h] of cubes, each cut into the six Kuhn tetrahedra around the diagonal (0,0,0) to
/// (1,1,1). Node (i, j, k) has number (k (ny+1) + j) (nx+1) + i.
/// @param h  edge of a cube [m]
Mesh kuhn_block(int nx, int ny, int nz, double h);

/// The corner of a cube with edge h [m]: one tetrahedron.
Mesh one_tetrahedron(double h);

/// Flat sheet [0, nx h] x [0, ny h] at z = 0 of triangles, normal +z; node (i, j) has number j (nx+1) + i.
Mesh sheet(int nx, int ny, double h);

/// Nodes of the mesh with z below `height` [m], ascending.
std::vector<int> nodes_below(const Mesh& mesh, double height);

}  // namespace kt
