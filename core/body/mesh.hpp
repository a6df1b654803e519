#pragma once
// A body as data, its mesh at rest (surface triangles and, for a solid, tetrahedra), and its state.
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

struct EmbeddedSurface;  // core/body/embedded_surface.hpp

/// Rest geometry of one body. Plain data, filled by readers, read by models and collision.
struct Mesh {
  VectorX x;                            ///< rest positions [m], (3n)
  std::vector<Triangle> triangles;      ///< surface, counter-clockwise seen from outside
  std::vector<Tetrahedron> tetrahedra;  ///< empty for a surface mesh
  /// Set where the triangles are a surface inside the tetrahedra. Else they are the tetrahedra's own, or there are
  /// none.
  std::shared_ptr<const EmbeddedSurface> embedded = {};

  int num_nodes() const { return static_cast<int>(x.size() / 3); }
  /// Without the vertices of an embedded surface.
  int num_own_nodes() const;
  bool operator==(const Mesh&) const = default;
};

/// Everything of a body that changes globally. A copy is a snapshot.
struct State {
  double t = 0;  ///< [s]
  VectorX x, v;  ///< positions [m], velocities [m/s], (3n)
  bool operator==(const State&) const = default;
};

/// A point of the body's surface.
struct SurfacePlace {
  int triangle = -1;            ///< -1 for none
  Vec3 weights = Vec3::Zero();  ///< weights of its corners, sum 1
};

struct Bounds {
  Vec3 min = Vec3::Constant(0), max = Vec3::Constant(0);
  Vec3 size() const { return max - min; }
  Vec3 centre() const { return 0.5 * (min + max); }
};

/// Bounding box of all nodes [m], of an embedded surface's where there is one; zero for an empty mesh.
Bounds bounds(const Mesh& mesh);

/// Surface of a tetrahedral mesh, the faces that belong to one tetrahedron only, counter-clockwise seen from outside.
std::vector<Triangle> boundary_triangles(const std::vector<Tetrahedron>& tetrahedra);

/// Box [0, nx h] x [0, ny h] x [0, nz h] of cubes, each cut into the six Kuhn tetrahedra around the diagonal (0,0,0) to
/// (1,1,1). Node (i, j, k) has number (k (ny+1) + j) (nx+1) + i.
/// @param h  edge of a cube [m]
Mesh kuhn_block(int nx, int ny, int nz, double h);

/// Volume enclosed by a closed surface [m^3], by the divergence theorem. Negative when the surface is inside out.
double enclosed_volume(const Mesh& mesh);

/// Volume of one tetrahedron [m^3], signed.
double tetrahedron_volume(const VectorX& x, const Tetrahedron& t);

/// Area-weighted unit normals of the surface nodes at positions x (3n), zero for nodes not on the surface.
VectorX node_normals(const VectorX& x, const std::vector<Triangle>& triangles);

}  // namespace kt
