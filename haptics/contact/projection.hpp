#pragma once
// The paper's operators P, P~, Q, Q~ in closed form: no 3m x 3m matrix is ever built.
// docs/method.md#6-the-papers-laws-528
#include "core/types.hpp"

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

}  // namespace kt
