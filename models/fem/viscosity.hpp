#pragma once
// Damping by the rate of strain (Kelvin-Voigt): P_v = F (2 eta E' + zeta tr(E') I) with E' = sym(F^T F').
// Turning the body as a whole strains nothing, so it is not damped. At rest it is Rayleigh's stiffness damping: eta,
// zeta are the Lame constants times the damping time. For the linear material F = I, and it is Rayleigh's everywhere.
#include "models/fem/material.hpp"

namespace kt {

class Viscosity {
 public:
  /// @param time  [s], >= 0: damping = time * stiffness
  Viscosity(const Lame& lame, double time, bool turns)
      : eta_(time * lame.mu), zeta_(time * lame.lambda), turns_(turns) {}
  bool is_active() const { return eta_ != 0 || zeta_ != 0; }

  /// First Piola-Kirchhoff stress [Pa] at F and F' = `rate` [1/s].
  Mat3 stress(const Mat3& F, const Mat3& rate) const {
    const Mat3& shape = turns_ ? F : identity();
    return shape * second(shape, rate);
  }

  /// dP_v / dF' [Pa s], (9 x 9), symmetric positive semidefinite:
  /// (ij, kl) -> eta ((F F^T)_ik d_jl + F_il F_kj) + zeta F_ij F_kl.
  Mat9 tangent_of_rate(const Mat3& F) const {
    const Mat3& shape = turns_ ? F : identity();
    return products(shape, shape);
  }

  /// dP_v / dF [Pa], (9 x 9), not symmetric.
  Mat9 tangent_of_shape(const Mat3& F, const Mat3& rate) const {
    if (!turns_) return Mat9::Zero();
    const Mat3 S = second(F, rate);
    Mat9 out = products(F, rate);
    for (int j = 0; j < 3; ++j)
      for (int l = 0; l < 3; ++l) out.block<3, 3>(3 * j, 3 * l).diagonal().array() += S(l, j);
    return out;
  }

 private:
  static const Mat3& identity() {
    static const Mat3 one = Mat3::Identity();
    return one;
  }
  Mat3 second(const Mat3& shape, const Mat3& rate) const {
    const Mat3 half = shape.transpose() * rate;
    const Mat3 E = 0.5 * (half + half.transpose());
    return 2 * eta_ * E + zeta_ * E.trace() * Mat3::Identity();
  }
  /// (ij, kl) -> eta (A_il B_kj + d_jl (A B^T)_ik) + zeta A_ij B_kl.
  Mat9 products(const Mat3& A, const Mat3& B) const {
    const Mat3 AB = eta_ * A * B.transpose();
    Mat9 out = (zeta_ * flat(A)) * flat(B).transpose();
    for (int j = 0; j < 3; ++j)
      for (int l = 0; l < 3; ++l) {
        auto block = out.block<3, 3>(3 * j, 3 * l);
        block.noalias() += (eta_ * A.col(l)) * B.col(j).transpose();
        if (j == l) block += AB;
      }
    return out;
  }
  double eta_, zeta_;
  bool turns_;
};

}  // namespace kt
