#pragma once
// Polygons of OBJ, OFF and PLY files to triangles.
#include <span>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Collects polygons as triangles and remembers what it had to do, for the notes of load_mesh.
class PolygonTriangulator {
 public:
  static constexpr std::size_t kMostCorners = 10000;  ///< of a polygon whose ears are cut: a second or two

  /// Appends the triangles of one polygon with corners at positions x (3n): a fan where the polygon is convex, else
  /// ears cut in the plane of its Newell normal (a fan again when even that fails). Keeps all n corners and the
  /// boundary edges.
  void add(const VectorX& x, std::span<const int> corners, std::vector<Triangle>& out);

  /// Sentences like "12 polygons split into triangles, 3 of them not convex"; empty when all faces were triangles.
  std::vector<std::string> notes() const;

 private:
  int polygons_ = 0, concave_ = 0, failed_ = 0;
};

}  // namespace kt
