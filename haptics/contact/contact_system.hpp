#pragma once
// Several contacts at one instant, and how far impulses are from Coulomb's conditions at them.
#include <span>

#include "haptics/contact/friction.hpp"

namespace kt {

/// Borrowed views; c contacts, stacked, world frame. v+ = velocity + W p.
struct ContactSystem {
  std::span<const Vec3> normal;        ///< unit, from the body towards the tool, (c)
  std::span<const Friction> friction;  ///< (c)
  std::span<const bool> sliding;       ///< its tool slid before: OneContact::solve; empty: none did
  Eigen::Ref<const VectorX> velocity;  ///< of the body's contact points without contact, against the tool [m/s], (3c)
  Eigen::Ref<const MatrixX, 0, Eigen::OuterStride<>> W;  ///< [1/kg], symmetric positive semidefinite, (3c x 3c)

  int count() const noexcept { return static_cast<int>(normal.size()); }
  /// A contact's inverse of its mean mobility [kg]; 0: it cannot move.
  double mass(int i) const noexcept {
    const double trace = W(3 * i, 3 * i) + W(3 * i + 1, 3 * i + 1) + W(3 * i + 2, 3 * i + 2);
    return trace > 0 ? 3 / trace : 0;
  }
};

/// How far impulses p with velocities u = velocity + W p are from Coulomb's conditions: the largest over the contacts
/// of
///   e = | p - K(p - r (u + mu |u_t| m)) |,   r = 3 / trace of the contact's own block of W,
/// K the projection on its friction cone (De Saxce and Feng 1998), as an impulse relative to the largest impulse, or,
/// where that is more, as a velocity e / r relative to the largest velocity without contact. Zero exactly at solutions:
/// no penetration, no pull, in the cone, free or touching, slip against friction. Nothing in it depends on units.
/// @param mu  per contact, of the cone it is to lie in: the static coefficient where it sticks, 0 where it is free
double natural_residual(const ContactSystem& system, const Eigen::Ref<const VectorX>& p,
                        const Eigen::Ref<const VectorX>& u, std::span<const double> mu) noexcept;

}  // namespace kt
