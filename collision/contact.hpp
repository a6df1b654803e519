#pragma once
// What collision detection takes and gives: tool shapes, their path over a step, and contacts. No forces here.
#include <span>
#include <string>

#include "core/types.hpp"

namespace kt {

/// The shape that touches the body; its reference point is the centre.
struct ToolShape {
  enum class Kind { point, sphere } kind = Kind::point;
  double radius = 0;  ///< [m], > 0 for a sphere, 0 for a point
  bool operator==(const ToolShape&) const = default;
};

/// Straight path of the tool's reference point over one step.
struct ToolSweep {
  Vec3 x_t0 = Vec3::Zero(), x_t1 = Vec3::Zero();  ///< [m]
};

/// Triangles whose vertices move on straight lines over one step. Borrowed views; nothing is owned.
struct MovingTriangles {
  std::span<const Triangle> triangles;  ///< vertex indices into x_t0 and x_t1
  const VectorX& x_t0;                  ///< stacked positions at the start of the step [m], (3p)
  const VectorX& x_t1;                  ///< at its end
};

/// One place where the tool touches (or nearly touches) a triangle.
struct Contact {
  int triangle = -1;
  Vec3 bary = Vec3::Zero();    ///< weights of the triangle's vertices, sum 1
  Vec3 normal = Vec3::Zero();  ///< unit, from the body towards the tool
  double gap = 0;              ///< distance of the tool's surface from the triangle at `toi` [m]; negative: inside
  double toi = 0;              ///< fraction of the step, [0, 1]
  bool operator==(const Contact&) const = default;
};

}  // namespace kt
