// St. Venant-Kirchhoff: Hooke's law in the Green strain E = (F^T F - I)/2. Its stress falls again below 58 % of the
// rest length and is zero at zero length: crushed elements stay crushed.
#include <Eigen/Eigenvalues>

#include "models/fem/lane_material.hpp"

namespace kt {
namespace {

class StVenantKirchhoff final : public LaneMaterial<StVenantKirchhoff> {
 public:
  explicit StVenantKirchhoff(const Lame& lame) : lame_(lame) {}
  double energy(const Mat3& F) const override {
    const Mat3 E = green(F);
    return lame_.mu * E.squaredNorm() + 0.5 * lame_.lambda * E.trace() * E.trace();
  }
  template <class T>
  Mat3Of<T> stress_of(const Mat3Of<T>& F) const {
    return F * second(F);
  }
  Mat9 tangent(const Mat3& F) const override {
    const Mat3 S = second(F);
    Mat9 out;
    for (int c = 0; c < 9; ++c) {
      Mat3 dF = Mat3::Zero();
      dF(c % 3, c / 3) = 1;
      const Mat3 half = F.transpose() * dF;
      const Mat3 dE = 0.5 * (half + half.transpose());
      const Mat3 dP = dF * S + F * (2 * lame_.mu * dE + lame_.lambda * dE.trace() * Mat3::Identity());
      out.col(c) = flat(dP);
    }
    return out;
  }
  /// The part of the stress S itself, dF S, with S's negative eigenvalues set to zero; the rest is positive anyway.
  Mat9 definite_tangent(const Mat3& F) const override {
    const Mat3 S = second(F), lift = without_pressure(S) - S;
    Mat9 out = tangent(F);
    for (int j = 0; j < 3; ++j)
      for (int l = 0; l < 3; ++l) out.block<3, 3>(3 * j, 3 * l).diagonal().array() += lift(j, l);
    return out;
  }
  /// (g_a.S g_b) I + lambda (F g_a)(F g_b)^T + mu ((F g_b)(F g_a)^T + (g_a.g_b) F F^T).
  void add_stiffness_to(const LaneStiffness& s) const {
    const auto& [F, definite, g, volume, blocks] = s;
    LaneMat3 S = second(F);
    if (definite && !is_definite(S + (1e-12 * sqrt(S.squaredNorm())) * LaneMat3::Identity()))
      for (int lane = 0; lane < Lanes::kCount; ++lane) set_lane(S, lane, without_pressure(get_lane(S, lane)));
    const LaneMat3 FF = F * F.transpose();
    const PerNode f = per_node(F, g);
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 mu_f = (Lanes(lame_.mu) * volume) * f[b], lambda_f = (Lanes(lame_.lambda) * volume) * f[b];
      const LaneVec3 mu_g = (Lanes(lame_.mu) * volume) * g[b], sb = S * (volume * g[b]);
      for (std::size_t a = 0; a < b; ++a, ++block) {
        const Lanes even = g[a].dot(mu_g), along = g[a].dot(sb);
        for (int i = 0; i < 3; ++i) {
          block->col(i) += f[a][i] * mu_f + lambda_f[i] * f[a] + even * FF.col(i);
          (*block)(i, i) += along;
        }
      }
    }
  }

 private:
  static Mat3 green(const Mat3& F) { return 0.5 * (F.transpose() * F - Mat3::Identity()); }
  template <class T>
  Mat3Of<T> second(const Mat3Of<T>& F) const {
    const Mat3Of<T> E2 = F.transpose() * F - Mat3Of<T>::Identity();
    Mat3Of<T> out = T(lame_.mu) * E2;
    const T spherical = T(0.5 * lame_.lambda) * E2.trace();
    for (int i = 0; i < 3; ++i) out(i, i) += spherical;
    return out;
  }
  static Mat3 without_pressure(const Mat3& S) {
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(S);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  }
  Lame lame_;
};

}  // namespace

std::unique_ptr<Material> make_stvk_material(const Lame& lame) { return std::make_unique<StVenantKirchhoff>(lame); }

}  // namespace kt
