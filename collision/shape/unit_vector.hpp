#pragma once
// Directions of vectors of any length.
#include "core/base/types.hpp"

namespace kt {

/// v as a unit vector, also where the square of its length underflows; zero if v is.
inline Vec3 unit_vector(const Vec3& v) noexcept {
  constexpr double kSquarable = 0x1p-480;
  if (const double length = v.norm(); length > kSquarable) return v / length;
  const double largest = v.lpNorm<Eigen::Infinity>();
  return largest > 0 ? Vec3((v / largest).normalized()) : Vec3(Vec3::Zero());
}

}  // namespace kt
