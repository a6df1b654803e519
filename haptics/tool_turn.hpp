#pragma once
// How the tool is turned over time: a fixed orientation, and an even spin about its reference point.
#include "collision/contact.hpp"
#include "io/scene.hpp"

namespace kt {

/// Rotation by |v| [rad] about v.
inline Quaternion rotation(const Vec3& v) {
  const double angle = v.norm();
  return angle > 0 ? Quaternion(Eigen::AngleAxisd(angle, v / angle)) : Quaternion::Identity();
}

struct ToolTurn {
  Vec3 turn = Vec3::Zero();  ///< rotation vector at t = 0 [rad]
  Vec3 spin = Vec3::Zero();  ///< angular velocity [rad/s]

  Quaternion at(double t) const { return rotation(t * spin) * rotation(turn); }
  ToolSweep sweep(const Vec3& x_t0, const Vec3& x_t1, double t0, double t1) const {
    return {x_t0, x_t1, at(t0), at(t1)};
  }
};

inline ToolTurn scene_turn(const SceneTool& tool) { return {tool.turn, tool.spin}; }

}  // namespace kt
