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

  /// The stress that turns with the element makes dP_v/dF unsymmetric.
  bool is_symmetric() const { return !turns_ || !is_active(); }

  /// First Piola-Kirchhoff stress [Pa] at F and F' = `rate` [1/s].
  template <class T>
  Mat3Of<T> stress(const Mat3Of<T>& F, const Mat3Of<T>& rate) const {
    if (!turns_) return second<T>(Mat3Of<T>::Identity(), rate);
    return F * second(F, rate);
  }

  /// Symmetric part of dP_v/dF [Pa], (9 x 9).
  Mat9 shape_tangent(const Mat3& F, const Mat3& rate) const {
    Mat9 out = Mat9::Zero();
    if (is_symmetric()) return out;
    const Mat3 S = second<double>(F, rate);
    for (int c = 0; c < 9; ++c) {
      Mat3 dF = Mat3::Zero();
      dF(c % 3, c / 3) = 1;
      out.col(c) = flat(Mat3(dF * S + F * second<double>(dF, rate)));
    }
    return 0.5 * (out + out.transpose());
  }

  /// blocks(a, b) += volume dP_v/dF' contracted with g_a and g_b, for pairs a < b as in Material::add_lane_stiffness:
  /// eta ((g_a.g_b) F F^T + (F g_b)(F g_a)^T) + zeta (F g_a)(F g_b)^T. Symmetric, positive semidefinite.
  void add_rate_blocks(const LaneMat3& F, std::span<const LaneVec3> g, const Lanes& volume,
                       std::span<LaneMat3> blocks) const {
    const LaneMat3 shape = turns_ ? F : LaneMat3(LaneMat3::Identity());
    const LaneMat3 FF = shape * shape.transpose();
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 fb = shape * g[b], eta_fb = (Lanes(eta_) * volume) * fb, zeta_fb = (Lanes(zeta_) * volume) * fb;
      for (std::size_t a = 0; a < b; ++a, ++block) {
        const LaneVec3 fa = shape * g[a];
        *block += (Lanes(eta_) * volume * g[a].dot(g[b])) * FF + eta_fb * fa.transpose() + fa * zeta_fb.transpose();
      }
    }
  }

  /// The same of dP_v/dF with S = 2 eta E' + zeta tr(E') I:
  /// eta ((F g_b)(F' g_a)^T + (g_a.g_b) F F'^T) + zeta (F g_a)(F' g_b)^T + (g_b.S g_a) I.
  /// Not symmetric: `transposed`(a, b) gets the transposed block (b, a).
  void add_shape_blocks(const LaneMat3& F, const LaneMat3& rate, std::span<const LaneVec3> g, const Lanes& volume,
                        std::span<LaneMat3> blocks, std::span<LaneMat3> transposed) const {
    if (is_symmetric()) return;
    const LaneMat3 S = second(F, rate), FR = F * rate.transpose();
    const Lanes eta = eta_ * volume, zeta = zeta_ * volume;
    auto block = blocks.begin(), other = transposed.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 fb = F * g[b], rb = rate * g[b];
      for (std::size_t a = 0; a < b; ++a, ++block, ++other) {
        const LaneVec3 fa = F * g[a], ra = rate * g[a];
        const LaneMat3 even = (eta * g[a].dot(g[b])) * FR;
        const Lanes along = volume * g[b].dot(S * g[a]);
        *block += even + (eta * fb) * ra.transpose() + (zeta * fa) * rb.transpose();
        *other += even.transpose() + rb * (eta * fa).transpose() + ra * (zeta * fb).transpose();
        for (int i = 0; i < 3; ++i) {
          (*block)(i, i) += along;
          (*other)(i, i) += along;
        }
      }
    }
  }

 private:
  template <class T>
  Mat3Of<T> second(const Mat3Of<T>& shape, const Mat3Of<T>& rate) const {
    const Mat3Of<T> half = shape.transpose() * rate;
    Mat3Of<T> out = T(eta_) * (half + half.transpose());
    const T spherical = T(zeta_) * half.trace();
    for (int i = 0; i < 3; ++i) out(i, i) += spherical;
    return out;
  }
  double eta_, zeta_;
  bool turns_;
};

}  // namespace kt
