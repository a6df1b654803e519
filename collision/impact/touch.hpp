#pragma once
// Where and how two features touch, once the time is known.
#include "collision/impact/touch_times.hpp"

namespace kt {

/// Where and how two features touch at a time, by places.
struct FeatureTouch {
  double weight[4];
  bool is_zero[4] = {false, false, false, false};  ///< weights that rounding cannot tell from zero
  Vec3 normal;
};

/// areas: those at time t.
FeatureTouch touch_at(const RoundedMotion& m, double t, const touch_times::Areas& areas) noexcept;

}  // namespace kt
