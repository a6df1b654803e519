#pragma once
// How a tool that follows a script is turned over time: a fixed orientation, and an even spin about its reference
// point.
#include "collision/shape/pose.hpp"

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
};

}  // namespace kt
