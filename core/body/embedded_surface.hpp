#pragma once
// A surface inside the cells of a body: its vertices are nodes of the mesh that are no unknowns, but move with the
// nodes of one cell each: its corners, or the ten of a quadratic cell. Linear: a force on a vertex goes to these nodes
// with the same weights.
#include <memory>
#include <vector>

#include "core/body/node_weights.hpp"

namespace kt {

/// Where the material of each cell is. Const, and asked from any number of threads.
class MaterialField {
 public:
  MaterialField() = default;
  MaterialField(const MaterialField&) = delete;
  MaterialField& operator=(const MaterialField&) = delete;
  virtual ~MaterialField() = default;
  /// Whether a cell is material all through.
  virtual bool is_whole(int cell) const = 0;
  /// How far inside the cell's material a place of it is, from the surface; below 0 outside [m].
  /// @param most  beyond it, it is this
  virtual double depth(int cell, const Vec3& place, double most) const = 0;
};

/// Four places of a cell, as weights of its corners, a column each: with a quarter of the material each they integrate
/// functions up to the second degree over it.
using CellPoints = Eigen::Matrix4d;

/// Triangles whose first vertices are in one cell, and the nodes of the cells of all of their vertices.
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
  std::vector<int> cube;  ///< of each tetrahedron, the piece of a cube that it is in, ascending from 0
  double edge = 0;        ///< of the cubes that the tetrahedra fill [m]

  std::shared_ptr<const MaterialField> material;  ///< of which `share` is made
  EmbeddedGroups groups;                          ///< of the mesh's triangles, group_triangles() of them

  double thickness = 0;  ///< of the material below most of the surface [m]; at most a few edges
  /// Of each tetrahedron, of ten nodes, those in the middles of its edges (kCellEdges); none: they have four.
  std::vector<std::array<int, 6>> middles;
  std::vector<CellPoints> points;  ///< of each tetrahedron of ten nodes: of its material

  int num_vertices() const { return static_cast<int>(corners.size()); }
  bool is_quadratic() const { return !middles.empty(); }
  /// Between nodes, mean [m].
  double spacing() const { return is_quadratic() ? 0.5 * edge : edge; }
  /// The nodes that carry a vertex, without those of weight 0; corners first.
  NodeWeights carried_by(int vertex) const;
  /// Fills `groups`.
  void group_triangles(const std::vector<Triangle>& triangles);
  /// Places the vertices of positions or velocities (3n) where their cells have them.
  void follow(VectorX& x) const;
  /// Of the point of a triangle of vertices, by nodes of the mesh.
  NodeWeights moved_by(const std::array<int, 3>& triangle, const Vec3& bary) const;
};

}  // namespace kt
