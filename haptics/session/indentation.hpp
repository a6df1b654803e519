#pragma once
// How far a tool has pushed the surface in, for traces and pictures.
#include <memory>

#include "collision/broad/triangle_index.hpp"
#include "core/body/mesh.hpp"

namespace kt {

/// Against the surface of a body before it was touched.
class Indentation {
 public:
  /// @param triangles  borrowed      @param x  where the body's nodes were (3n) [m]; borrowed
  Indentation(const std::vector<Triangle>& triangles, const VectorX& x);
  /// From the place where the tool touches now, along the contact normal, to where the surface was [m]: positive where
  /// it was pushed in, negative where it has come towards the tool. Not a number where that line does not meet it.
  /// @param normal  unit, from the body towards the tool
  double at(const Vec3& place, const Vec3& normal) const;

 private:
  const std::vector<Triangle>& triangles_;
  const VectorX& x_;
  double size_ = 0;  // of the body [m]
  std::unique_ptr<TriangleIndex> index_;
  mutable std::vector<int> near_;
};

}  // namespace kt
