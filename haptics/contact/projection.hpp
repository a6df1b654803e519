#pragma once
// The paper's operators P, P~, Q, Q~ in closed form: no 3m x 3m matrix is ever built.
// docs/method.md#6-the-papers-laws-528
#include <Eigen/LU>

#include "core/base/types.hpp"

namespace kt {

/// s in J J^T = s I: the sum of the squared weights of the vertices that can move.                     Paper eq. (7).
inline double weight_square(const Vec3& bary, const std::array<bool, 3>& moves) {
  double s = 0;
  for (int i = 0; i < 3; ++i) s += moves[i] ? bary[i] * bary[i] : 0.0;
  return s;
}

/// The split of a force at a contact into normal and tangential parts.                     Paper, section IV.A.
struct SplitForce {
  double normal = 0;               ///< F_N along the normal [N], negative when it pulls
  Vec3 tangential = Vec3::Zero();  ///< [N]
};
inline SplitForce split(const Vec3& force, const Vec3& normal) {
  const double n = normal.dot(force);
  return {n, force - n * normal};
}

/// The force clipped to the friction cone: f_n + mu |f_n| f_t / |f_t|.                         Paper eqs. (24), (28).
/// Differs from the paper: without a tangential force its direction is undefined; the limit 0 is taken.
inline Vec3 clip_to_cone(const Vec3& force, const Vec3& normal, double mu) {
  const auto [n, t] = split(force, normal);
  const double length = t.norm();
  return length > 0 ? Vec3(n * normal + mu * std::abs(n) / length * t) : Vec3(n * normal);
}

/// The paper's operators as they act on a contact, n its unit normal. W = J C J^T is the velocity of the contact point
/// per impulse there [1/kg]: in the paper's metric C = I and W = s I. force: J f / s of the body's forces f [N].
namespace paper {

/// P = I - J^T J / s: the impulse J^T of which leaves the contact point no velocity [N s].        Paper eq. (10).
inline Vec3 P(const Mat3& W, const Vec3& velocity) { return -W.inverse() * velocity; }

/// P~ = J^T J / s: the force on the tool of P~ f, summed over the triangle's nodes [N].    Paper eqs. (13), (14).
inline Vec3 P_tilde(const Vec3& force) { return force; }

/// Q = I - J^T n n^T J / s: the impulse that leaves it no velocity along n [N s].                 Paper eq. (19).
inline Vec3 Q(const Mat3& W, const Vec3& n, const Vec3& velocity) { return -n * (n.dot(velocity) / n.dot(W * n)); }

/// Q~ = J^T n n^T J / s: the force on the tool of Q~ f [N].                                Paper eqs. (21), (22).
inline Vec3 Q_tilde(const Vec3& force, const Vec3& n) { return split(force, n).normal * n; }

}  // namespace paper

}  // namespace kt
