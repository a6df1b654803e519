#pragma once
// Several contacts with exact Coulomb friction: block Gauss-Seidel over exact one-contact solves (Jourdan, Alart and
// Jean 1998), accelerated by Anderson's extrapolation (Walker and Ni 2011). Any number of contacts; no allocation.
#include <span>
#include <vector>

#include "haptics/contact/one_contact.hpp"

namespace kt {

/// The contacts of one instant as borrowed views; c contacts, stacked, world frame. v+ = velocity + W p.
struct ContactSystem {
  std::span<const Vec3> normal;        ///< unit, from the body towards the tool, (c)
  std::span<const Friction> friction;  ///< (c)
  std::span<const bool> sliding;       ///< its tool slid before: OneContact::solve; empty: none did
  Eigen::Ref<const VectorX> velocity;  ///< of the body's contact points without contact, against the tool [m/s], (3c)
  Eigen::Ref<const MatrixX, 0, Eigen::OuterStride<>> W;  ///< [1/kg], symmetric positive semidefinite, (3c x 3c)
};

struct SweepLimits {
  int sweeps = 100;
  double residual = 1e-6;  ///< converged: see natural_residual
};

struct SweepResult {
  int sweeps = 0;
  double residual = 0;
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

/// Room for up to `capacity` contacts, made once; belongs to one thread.
class ContactSweeps {
 public:
  explicit ContactSweeps(int capacity);

  /// @param impulse  in: to start from; out: the result, inside the cones and without pull, converged or not, (3c)
  /// With more rows than the body has freedoms W is singular: velocities are still unique where they are without
  /// friction, impulses are not, and the ones found are near those that it started from.
  SweepResult solve(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                    std::span<ContactMode> mode) noexcept;

 private:
  static constexpr int kDepth = 4;  // differences that the extrapolation remembers
  void find_velocity(const ContactSystem& system, const Eigen::Ref<const VectorX>& impulse) noexcept;
  double sweep(const ContactSystem& system, Eigen::Ref<VectorX> impulse, std::span<ContactMode> mode) noexcept;
  void extrapolate(Eigen::Ref<VectorX> impulse, int n) noexcept;
  void remember(const Eigen::Ref<const VectorX>& impulse, int n) noexcept;

  std::vector<OneContact> contact_;
  std::vector<double> mu_;
  std::vector<int> slips_;      // times that a contact went from sticking to slipping in this solve
  std::vector<double> lambda_;  // of each contact's last slip; -1: not known yet
  VectorX velocity_;            // with the present impulses
  VectorX before_, step_;       // impulses before the last sweep, and what it changed
  VectorX last_step_, last_impulse_, last_velocity_;
  MatrixX steps_, impulses_, velocities_;  // differences between successive sweeps, (3c x kDepth), a ring
  Eigen::Matrix<double, kDepth, kDepth> gram_;
  std::array<double, kDepth> along_{};  // products of steps_ with the last sweep's step
  int remembered_ = 0, next_ = 0;
  bool has_last_ = false;
};

}  // namespace kt
