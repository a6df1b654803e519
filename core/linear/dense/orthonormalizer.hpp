#pragma once
// From a Gram matrix alone: which of some motions have anything new to give, and how to mix them so that these stand
// apart.
#include <cmath>

#include "core/base/types.hpp"

namespace kt {

/// T with T^T G T = 1 but for columns of zeros, where the motion is the others' to within 1e-5 of what cancels in it
/// (Gram-Schmidt, twice). What cancels, and not the motion's own length: where it was made of others that had little
/// new themselves, their large weights take its digits.
/// @param gram  G, positive semidefinite
template <int N>
Eigen::Matrix<double, N, N> orthonormalizer(const Eigen::Matrix<double, N, N>& gram) {
  constexpr double kDependentSq = 1e-10;
  using Square = Eigen::Matrix<double, N, N>;
  Square out = Square::Zero();
  for (int c = 0; c < N; ++c) {
    Eigen::Vector<double, N> t = Eigen::Vector<double, N>::Unit(c);
    for (int pass = 0; pass < 2; ++pass)
      for (int k = 0; k < c; ++k) t -= out.col(k) * (out.col(k).dot(gram * t));
    const double rest_sq = t.dot(gram * t), cancels_sq = t.cwiseAbs().dot(gram.cwiseAbs() * t.cwiseAbs());
    if (rest_sq > kDependentSq * cancels_sq) out.col(c) = t / std::sqrt(rest_sq);
  }
  return out;
}

}  // namespace kt
