#pragma once
// How a device's frame lies in the world: world = origin + scale R device, with R a signed permutation of the axes.
#include <string>

#include "core/base/types.hpp"

namespace kt {

/// R of "X-ZY": the world's x is the device's x, the world's y its -z, the world's z its y. Throws InputError for what
/// is no signed permutation, or turns right hands into left ones.
Mat3 device_axes(const std::string& axes);

struct DeviceFrame {
  Mat3 r = Mat3::Identity();
  Vec3 origin = Vec3::Zero();  ///< of the device's zero [m]
  double scale = 1;            ///< way of the tool / way of the device

  Vec3 to_world(const Vec3& x) const noexcept { return origin + scale * (r * x); }
  Quaternion to_world(const Quaternion& turn) const noexcept { return Quaternion(r) * turn; }
  /// The origin with which the device at x is the tool at `at`.
  Vec3 origin_for(const Vec3& x, const Vec3& at) const noexcept { return at - scale * (r * x); }
};

}  // namespace kt
