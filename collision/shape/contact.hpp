#pragma once
// What collision detection takes and gives: the path of a tool over a step, and contacts. No forces here.
#include <span>

#include "collision/shape/tool_shape.hpp"

namespace kt {

/// Motion of the tool over one step: the reference point goes straight, the tool turns evenly about a fixed axis.
struct ToolSweep {
  Vec3 x_t0 = Vec3::Zero(), x_t1 = Vec3::Zero();                            ///< reference point [m]
  Quaternion r_t0 = Quaternion::Identity(), r_t1 = Quaternion::Identity();  ///< from the tool's frame to the world's

  ToolSweep() = default;
  ToolSweep(const Vec3& from, const Vec3& to, const Quaternion& turn_from = Quaternion::Identity(),
            const Quaternion& turn_to = Quaternion::Identity())
      : x_t0(from), x_t1(to), r_t0(turn_from), r_t1(turn_to) {}
  ToolSweep(const Pose& from, const Pose& to) : ToolSweep(from.x, to.x, from.r, to.r) {}
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
  Vec3 core = Vec3::Zero();    ///< held contacts: the place on the tool's core that is nearest [m]
  int tool = 0;                ///< which one of those that touch the body
  bool operator==(const Contact&) const = default;
};

}  // namespace kt
