#pragma once
// What a tool's path asks of the surface under it: the part of its motion that the body has to follow, found without
// running it.
#include <span>
#include <vector>

#include "core/local/reducer.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/excitation.hpp"

namespace kt {

/// What the surface follows of a ball, tick by tick [m]: how deep it is, along the normal of the body at rest, and how
/// far it takes the surface along, until friction lets it slip: by no more than mu times the depth.
/// @param path  in time; the ball stands still before its first point and after its last
class FollowedMotion {
 public:
  FollowedMotion(const Surface& surface, const VectorX& x, double radius, double mu);
  Vec3 move_to(const Vec3& place);

 private:
  void look_around(const Vec3& place);
  const Surface& surface_;
  const VectorX& x_;
  double radius_, mu_;
  Vec3 looked_from_ = Vec3::Zero(), last_ = Vec3::Zero(), dragged_ = Vec3::Zero();
  double searched_ = -1;   // [m] about looked_from_ within which near_ has the closest; below 0: nowhere
  std::vector<int> near_;  // triangles
  bool has_last_ = false;
};

/// The deepest place of a path [m], looked for every 5 ms of at most its first twenty seconds; 0: it touches nothing.
double path_depth(const std::vector<TimedPoint>& path, FollowedMotion motion);

/// Over the whole path, at most its first twenty seconds.
BandPowers path_powers(const std::vector<TimedPoint>& path, FollowedMotion motion, double rate_hz, double use);

}  // namespace kt
