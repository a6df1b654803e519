#pragma once
// The exact Coulomb law for one contact: Signorini's condition and friction against the sliding velocity.
#include "haptics/contact/contact_solver.hpp"

namespace kt {

struct OneContactSolution {
  Vec3 impulse = Vec3::Zero();  ///< on the body [N s]
  ContactMode mode = ContactMode::free;
};

/// Finds p with u = W p + b such that, m = -normal being the direction in which the tool pushes the body,
///   0 <= p_m  and  u_m >= 0  and  p_m u_m = 0;
///   stick: u_t = 0 with |p_t| <= mu_static p_m;   slip: |p_t| = mu_kinetic p_m with p_t opposite to u_t.
/// Slip is one root of a trigonometric polynomial of degree two in the direction of p_t, found by bracketing.
/// @param W  symmetric positive definite [1/kg]   @param b  velocity without contact [m/s]
OneContactSolution solve_one_contact(const Mat3& W, const Vec3& b, const Vec3& normal, const Friction& friction) noexcept;

}  // namespace kt
