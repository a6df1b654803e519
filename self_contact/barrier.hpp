#pragma once
// The force that keeps surfaces apart.                         Incremental potential contact, Li et al. 2020.
#include "core/base/types.hpp"

namespace kt {

/// b(d) = -stiffness (d - reach)^2 ln(d / reach) for 0 < d < reach, 0 beyond: twice continuously differentiable, and
/// infinite at d = 0.
struct Barrier {
  double reach = 1e-4;                     ///< distance from which on surfaces repel [m], > 0
  double stiffness = 1e3;                  ///< [N/m]
  double energy(double d) const noexcept;  ///< [J]
  double slope(double d) const noexcept;   ///< [N], <= 0
  double bend(double d) const noexcept;    ///< second derivative [N/m], >= 0
};

}  // namespace kt
