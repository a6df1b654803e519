#pragma once
// The friction law of one contact, and the modes of a contact.
#include <cmath>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

enum class ContactMode { free, stick, slide, frictional_slide };  ///< paper, section IV.A
const char* name_of(ContactMode mode);

struct Friction {
  double mu_static = 0, mu_kinetic = 0;  ///< mu_static >= mu_kinetic >= 0
  double stribeck =
      0;  ///< [m/s] sliding speed over which the static coefficient falls to the kinetic one, 0 for at once

  /// Coefficient at a sliding speed [m/s].                           Stribeck's curve in the form of Armstrong 1994.
  double mu_at(double speed) const noexcept {
    if (stribeck == 0) return mu_kinetic;
    const double v = speed / stribeck;
    return mu_kinetic + (mu_static - mu_kinetic) * std::exp(-v * v);
  }
  Friction times(double share) const noexcept { return {share * mu_static, share * mu_kinetic, stribeck}; }
  bool operator==(const Friction&) const = default;
};

/// Friction by place, between the tool's material and each part of the surface.
struct SurfaceFriction {
  Friction everywhere;
  std::vector<Friction> of_triangle;  ///< friction by surface triangle, empty for the same everywhere
  const Friction& at(int triangle) const noexcept {
    const auto i = static_cast<std::size_t>(triangle);  // negative where no place is known
    return i < of_triangle.size() ? of_triangle[i] : everywhere;
  }
};

}  // namespace kt
