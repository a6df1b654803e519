#pragma once
// Broad phase of a surface with itself: which vertices and triangles, and which edges, may meet during a motion?
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "collision/broad/triangle_index.hpp"

namespace kt {

/// Two features of one surface without a common node: a vertex and a triangle (v, a, b, c) or two edges (a0, a1, b0,
/// b1), by their nodes.
struct SurfacePair {
  enum class Kind { vertex_face, edge_edge } kind = Kind::vertex_face;
  std::array<int, 4> nodes{};
  bool operator==(const SurfacePair&) const = default;
};

class SurfacePairs {
 public:
  /// @param triangles  of one or several bodies; duplicated, degenerate and non-manifold ones are taken as they are
  /// @param backend    of triangle_index.def
  SurfacePairs(std::span<const Triangle> triangles, const VectorX& x, const std::string& backend);

  /// Every pair whose boxes over the straight motion from x_t0 to x_t1 (3n) come within `margin` [m] of one another, in
  /// an order that neither backend nor threads change.
  const std::vector<SurfacePair>& find(const VectorX& x_t0, const VectorX& x_t1, double margin);

  const std::vector<int>& vertices() const { return vertices_; }           ///< nodes of the surface, ascending
  const std::vector<std::array<int, 2>>& edges() const { return edges_; }  ///< nodes (low, high), ascending

 private:
  void find_around_vertex(int vertex, const VectorX& x_t0, const VectorX& x_t1, double margin, std::span<int> near,
                          std::vector<SurfacePair>& out) const;
  void find_around_edge(int edge, const VectorX& x_t0, const VectorX& x_t1, double margin, std::span<int> near,
                        std::vector<SurfacePair>& out) const;
  std::vector<Triangle> triangles_;
  std::vector<int> vertices_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<std::array<int, 3>> edges_of_;  // of each triangle
  std::unique_ptr<TriangleIndex> index_;
  std::vector<SurfacePair> pairs_;
};

}  // namespace kt
