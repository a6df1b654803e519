#pragma once
// The exact Coulomb law for one contact: Signorini's condition and friction against the sliding velocity.
#include "haptics/contact/contact_solver.hpp"

namespace kt {

struct OneContactSolution {
  Vec3 impulse = Vec3::Zero();  ///< on the body [N s]
  ContactMode mode = ContactMode::free;
};

/// One contact with everything that stays the same over the sweeps of an iterative solver.
class OneContact {
 public:
  OneContact() = default;
  /// @param W  symmetric positive definite [1/kg]   @param normal  unit, from the body towards the tool
  OneContact(const Mat3& W, const Vec3& normal) noexcept;
  /// See solve_one_contact.
  OneContactSolution solve(const Vec3& b, const Friction& friction, const Vec3& guess) const noexcept;

 private:
  Mat3 frame_, W_, inverse_;  // contact frame (m, t1, t2); W and its inverse in it
};

/// Finds p with u = W p + b such that, m = -normal being the direction in which the tool pushes the body,
///   0 <= p_m  and  u_m >= 0  and  p_m u_m = 0;
///   stick: u_t = 0 with |p_t| <= mu_static p_m;   slip: |p_t| = mu_kinetic p_m with p_t opposite to u_t.
/// Slip is one root of a trigonometric polynomial of degree two in the direction of p_t: Newton from `guess` where that
/// converges, else bracketing around the circle. Jamming (mu times the coupling near W_mm) is cut off at an impulse of
/// a thousand times the frictionless one.
/// @param W      symmetric positive definite [1/kg]   @param b  velocity without contact [m/s]
/// @param guess  an impulse of about the same direction, for speed only; zero: none
OneContactSolution solve_one_contact(const Mat3& W, const Vec3& b, const Vec3& normal, const Friction& friction,
                                     const Vec3& guess = Vec3::Zero()) noexcept;

}  // namespace kt
