#pragma once
// When does a point go through a moving triangle, from its front or from its back? By the roots of the coplanarity in
// 113-bit arithmetic, with no gap between triangles that share an edge or a vertex. For tests.
#include <optional>
#include <vector>

#include "collision/shape/contact.hpp"
#include "tests/support/collision_oracle.hpp"
#include "tests/support/quad_point.hpp"

namespace kt {

/// First times in [0, 1]; nothing where it does not.
struct Crossings {
  std::optional<quad::Real> from_front, from_behind;
};

/// Ends count: a point that starts or ends on the triangle has gone through when it moves that way. Edges count for
/// both of their triangles (grown by 1e-18 of their size, far below what an engine in doubles tells apart). Motion in
/// the plane is no crossing, nor is anything of a triangle without area.
Crossings find_crossings(const CollisionQuery& q);

/// The same with all triangles of a surface, every one of which is looked at.
class CrossingOracle {
 public:
  explicit CrossingOracle(std::span<const Triangle> triangles) : triangles_(triangles) {}
  void refit(const VectorX& x_t0, const VectorX& x_t1);
  /// The earliest of all; `triangle` gets that which is crossed from the front.
  Crossings find(const ToolSweep& sweep, int& triangle) const;
  CollisionQuery query(const ToolSweep& sweep, int triangle) const;

 private:
  struct Box {
    Vec3 low, high;
  };
  std::span<const Triangle> triangles_;
  const VectorX *x_t0_ = nullptr, *x_t1_ = nullptr;
  std::vector<Box> boxes_;
};

}  // namespace kt
