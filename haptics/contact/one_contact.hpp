#pragma once
// The exact Coulomb law for one contact: Signorini's condition and friction against the sliding velocity.
#include "haptics/contact/friction.hpp"

namespace kt {

struct OneContactSolution {
  Vec3 impulse = Vec3::Zero();  ///< on the body [N s]
  ContactMode mode = ContactMode::free;
  double mu = 0;      ///< coefficient of the cone that holds the impulse: on its surface when slipping
  double lambda = 0;  ///< |u_t| / |p_t| when slipping [1/kg]
};

/// One contact with everything that stays the same over the sweeps of an iterative solver.
///
/// Finds p with u = W p + b such that, m = -normal being the direction in which the tool pushes the body,
///   0 <= p_m  and  u_m >= 0  and  p_m u_m = 0;
///   stick: u_t = 0 with |p_t| <= mu_static p_m;   slip: |p_t| = mu(|u_t|) p_m with p_t opposite to u_t.
///
/// With u_m = 0 the normal impulse follows from the tangential one, and slip, u_t = -lambda p_t, reads
///   (S + lambda) p_t = -c,   S = W_tt - W_tm W_mt / W_mm,   c = b_t - W_tm b_m / W_mm,
/// so that everything hangs on one number, lambda >= 0 [1/kg]: (mu p_m / |p_t|)^2 - 1 as its function is negative
/// at 0 (else it sticks) and grows without bound, so a root is bracketed from the start: for positive definite W there
/// is always a solution, whatever the friction, and no jamming. In the eigenvectors of S one evaluation costs a few
/// divisions; Newton's method takes one to four. The sliding speed is lambda |p_t|, so that Stribeck's law is the same
/// equation.                          Cf. the secular equation of trust regions: More and Sorensen 1983.
class OneContact {
 public:
  OneContact() = default;
  /// @param W  symmetric positive semidefinite [1/kg]; directions that do not move at all are given 1e-13 of its trace
  /// @param normal  unit, from the body towards the tool
  OneContact(const Mat3& W, const Vec3& normal) noexcept;

  /// @param b         velocity without contact [m/s]
  /// @param sliding   it slid before: static friction is overcome; sticks only when kinetic friction holds it, or when
  ///                  Stribeck's law leaves no sliding speed
  /// @param start     lambda to start from, for speed only; 0: unknown
  OneContactSolution solve(const Vec3& b, const Friction& friction, bool sliding = false,
                           double start = 0) const noexcept;

  /// The lambda that goes with an impulse at about this b.
  double slip_ratio(const Vec3& b, const Vec3& impulse) const noexcept;

 private:
  Mat3 frame_;                               // m and the eigenvectors of S
  double inverse_m_ = 0;                     // 1 / W_mm
  Eigen::Vector2d w_{}, s_{}, inverse_s_{};  // W_tm, eigenvalues of S
};

}  // namespace kt
