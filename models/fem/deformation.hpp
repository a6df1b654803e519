#pragma once
// Functions of a deformation gradient F that materials are made of.
#include <span>

#include "core/base/error.hpp"
#include "models/fem/lanes.hpp"

namespace kt {

using Mat9 = Eigen::Matrix<double, 9, 9>;

/// F and everything derived from it as vectors: column-major, (F00 F10 F20 F01 ...).
inline auto flat(const Mat3& m) { return m.reshaped(); }

/// m g_a for every node a of an element with at most 10.
using PerNode = std::array<LaneVec3, 10>;
inline PerNode per_node(const LaneMat3& m, std::span<const LaneVec3> g) {
  KT_ASSERT(g.size() <= std::tuple_size_v<PerNode>);
  PerNode out;
  for (std::size_t a = 0; a < g.size(); ++a) out[a] = m * g[a];
  return out;
}

/// Matrix of cofactors, det(F) F^-T, defined for singular F too: dJ/dF.
template <class T>
Mat3Of<T> cofactor(const Mat3Of<T>& F) {
  Mat3Of<T> out;
  for (int i = 0; i < 3; ++i) out.col(i) = Vec3Of<T>(F.col((i + 1) % 3)).cross(Vec3Of<T>(F.col((i + 2) % 3)));
  return out;
}

/// Symmetric matrices without a negative eigenvalue, in every lane, by the leading minors: a positive shift of the
/// diagonal by the caller keeps minors of zero from hiding one.
inline bool is_definite(const LaneMat3& m) {
  const LaneMat3 minors = cofactor(m);
  return none_negative(m(0, 0)) && none_negative(minors(2, 2)) && none_negative(m.col(0).dot(minors.col(0)));
}

/// d cofactor / dF, (9 x 9): the second derivative of the determinant.
Mat9 cofactor_tangent(const Mat3& F);

/// The rotation of F = R S with det R = +1 and S symmetric, also for an inverted F (then its smallest eigenvalue is
/// negative).
Mat3 rotation_of(const Mat3& F);
LaneMat3 rotation_of(const LaneMat3& F);

}  // namespace kt
