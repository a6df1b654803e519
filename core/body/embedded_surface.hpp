#pragma once
// A surface inside the cells of a body: its vertices are nodes of the mesh that are no unknowns, but move with the
// corners of one cell each. Linear: a force on a vertex goes to these corners with the same weights.
#include <vector>

#include "core/body/node_weights.hpp"

namespace kt {

/// Where the material is, on a grid finer than the cells.
struct MaterialSamples {
  Vec3 origin = Vec3::Zero();   ///< of the first sample's box
  Vec3 spacing = Vec3::Ones();  ///< [m]
  std::array<int, 3> count{0, 0, 0};
  std::vector<bool> is_inside;  ///< along x, then y, then z

  std::size_t index(const std::array<int, 3>& at) const {
    return static_cast<std::size_t>(at[0]) +
           static_cast<std::size_t>(count[0]) *
               (static_cast<std::size_t>(at[1]) + static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(at[2]));
  }
  bool at(const Vec3& place) const;  ///< of the nearest sample
  /// Share of a tetrahedron that is material, split among its corners by how near it is to each: the means of their
  /// weights over the material. Sum: the share.
  Eigen::Vector4d shares(const std::array<Vec3, 4>& corners) const;
};

/// Triangles whose first vertices are in one cell, and the corners of the cells of all of their vertices.
struct EmbeddedGroups {
  std::vector<int> first_triangle{0}, triangle, first_node{0}, node;
  int count() const { return static_cast<int>(first_triangle.size()) - 1; }
};

struct EmbeddedSurface {
  int first = 0;                               ///< the mesh's nodes from this one on are its vertices
  std::vector<int> cell;                       ///< tetrahedron that each vertex moves with
  std::vector<std::array<int, 4>> corners;     ///< of the cell that each vertex moves with: nodes below `first`
  std::vector<std::array<double, 4>> weights;  ///< sum 1; below 0 or above 1 where a vertex is just outside of it
  std::vector<double> share;                   ///< of each tetrahedron, how much of it is material, in (0, 1]
  double edge = 0;                             ///< of the cubes that the tetrahedra fill [m]

  MaterialSamples samples;  ///< as those that `share` comes from
  EmbeddedGroups groups;    ///< of the mesh's triangles, group_triangles() of them

  int num_vertices() const { return static_cast<int>(corners.size()); }
  /// Fills `groups`.
  void group_triangles(const std::vector<Triangle>& triangles);
  /// Places the vertices of positions or velocities (3n) where their cells have them.
  void follow(VectorX& x) const;
  /// Of the point of a triangle of vertices, by nodes of the mesh.
  NodeWeights moved_by(const std::array<int, 3>& triangle, const Vec3& bary) const;
};

}  // namespace kt
