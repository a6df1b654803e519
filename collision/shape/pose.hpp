#pragma once
// Where a rigid tool is, and what acts on it.
#include "core/base/types.hpp"

namespace kt {

using Quaternion = Eigen::Quaterniond;

struct Pose {
  Vec3 x = Vec3::Zero();                  ///< reference point, world frame [m]
  Quaternion r = Quaternion::Identity();  ///< unit, from the tool's frame to the world's

  bool is_finite() const noexcept { return x.allFinite() && r.coeffs().allFinite(); }
  bool operator==(const Pose& other) const noexcept { return x == other.x && r.coeffs() == other.r.coeffs(); }
};

struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< about the tool's reference point [N m]
};

}  // namespace kt
