#pragma once
// Singular values of four matrices at once, by one-sided Jacobi rotations (Hestenes 1958).
#include "models/fem/lanes.hpp"

namespace kt {

/// F = U diag(s) V^T with rotations U and V: s_3, the smallest in size, has the sign of det F.
struct LaneSvd {
  LaneMat3 U, V;
  LaneVec3 s;
};

/// Turns columns p and q of B, and of V, until they are orthogonal, the longer one first.
inline void orthogonalize(int p, int q, LaneMat3& B, LaneMat3& V) {
  const Lanes d = B.col(p).squaredNorm() - B.col(q).squaredNorm(), twice = Lanes(2) * B.col(p).dot(B.col(q));
  const Lanes size = abs(d) + 1e-100, r = sqrt(size * size + twice * twice);  // never zero
  const Lanes large = sqrt(0.5 + 0.5 * (size / r)), small = abs(twice) / (Lanes(2) * r * large);
  const Lanes c = select_negative(d, small, large), turn = select_negative(d, large, small);
  const Lanes s = select_negative(twice, -turn, turn);
  for (LaneMat3* m : {&B, &V}) {
    const LaneVec3 column = m->col(p);
    for (int i = 0; i < 3; ++i) {
      (*m)(i, p) = c * column[i] + s * (*m)(i, q);
      (*m)(i, q) = c * (*m)(i, q) - s * column[i];
    }
  }
}

inline LaneVec3 normalized_or(const LaneVec3& v, const LaneVec3& other) {
  const Lanes length = sqrt(v.squaredNorm());
  LaneVec3 out;
  for (int i = 0; i < 3; ++i) out[i] = select_negative(1e-150 - length, v[i] / length, other[i]);
  return out;
}

inline LaneSvd singular_values(const LaneMat3& F) {
  constexpr int kSweeps = 10;  // they square the error: four or five suffice
  LaneMat3 B = F;
  LaneSvd out;
  out.V.setIdentity();
  for (int i = 0; i < kSweeps; ++i) {
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) orthogonalize(p, q, B, out.V);
    const Lanes off = abs(B.col(0).dot(B.col(1))) + abs(B.col(0).dot(B.col(2))) + abs(B.col(1).dot(B.col(2)));
    if (all_less(off, 1e-15 * B.squaredNorm())) break;
  }
  // U from the columns by Gram and Schmidt, from another direction where they vanish; the third completes a rotation.
  const LaneVec3 u = normalized_or(B.col(0), LaneVec3::UnitX());
  LaneVec3 across;  // of length 0.4 at least
  for (int i = 0; i < 3; ++i) across[i] = select_negative(abs(u[0]) - 0.9, Lanes(i == 0), Lanes(i == 1));
  across = u.cross(across);
  // A second column that was only roundoff can lie along the first.
  const LaneVec3 second = B.col(1), rest = second - u.dot(second) * u;
  const LaneVec3 other = across / sqrt(across.squaredNorm()), found = normalized_or(rest, other);
  LaneVec3 v;
  for (int i = 0; i < 3; ++i)
    v[i] = select_negative(Lanes(0.5) * second.squaredNorm() - rest.squaredNorm(), found[i], other[i]);
  out.U << u, v, u.cross(v);
  for (int k = 0; k < 3; ++k) out.s[k] = out.U.col(k).dot(B.col(k));
  return out;
}

}  // namespace kt
