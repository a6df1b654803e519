// Hooke's law in the small strain e = sym(F) - I: energy = mu e:e + lambda/2 tr(e)^2.
#include "models/fem/material.hpp"

namespace kt {
namespace {

class Linear final : public Material {
 public:
  explicit Linear(const Lame& lame) : lame_(lame) {
    tangent_.setZero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        tangent_(i + 3 * j, i + 3 * j) += lame.mu;
        tangent_(i + 3 * j, j + 3 * i) += lame.mu;
        tangent_(4 * i, 4 * j) += lame.lambda;
      }
  }
  double energy(const Mat3& F) const override {
    const Mat3 e = strain(F);
    return lame_.mu * e.squaredNorm() + 0.5 * lame_.lambda * e.trace() * e.trace();
  }
  Mat3 stress(const Mat3& F) const override { return stress_of(F); }
  LaneMat3 lane_stress(const LaneMat3& F) const override {
    LaneMat3 P;
    find_stress(*this, F, P);
    return P;
  }
  Mat9 tangent(const Mat3&) const override { return tangent_; }
  /// mu ((g_a.g_b) I + g_b g_a^T) + lambda g_a g_b^T.
  void add_lane_stiffness(const LaneMat3& F, bool definite, std::span<const LaneVec3> g, const Lanes& volume,
                          std::span<LaneMat3> blocks) const override {
    add_stiffness(*this, {F, definite, g, volume, blocks});
  }
  bool is_frame_indifferent() const override { return false; }

 private:
  KT_LANES static void find_stress(const Linear& m, const LaneMat3& F, LaneMat3& P) { P = m.stress_of(F); }
  KT_LANES static void add_stiffness(const Linear& m, const LaneStiffness& s) {
    m.add_stiffness_to(s.F, s.definite, s.g, s.volume, s.blocks);
  }
  void add_stiffness_to(const LaneMat3&, bool, std::span<const LaneVec3> g, const Lanes& volume,
                        std::span<LaneMat3> blocks) const {
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 mu_g = (Lanes(lame_.mu) * volume) * g[b], lambda_g = (Lanes(lame_.lambda) * volume) * g[b];
      for (std::size_t a = 0; a < b; ++a, ++block) {
        const Lanes along = g[a].dot(mu_g);
        for (int i = 0; i < 3; ++i) {
          block->col(i) += g[a][i] * mu_g + lambda_g[i] * g[a];
          (*block)(i, i) += along;
        }
      }
    }
  }
  template <class T>
  static Mat3Of<T> strain(const Mat3Of<T>& F) {
    return T(0.5) * (F + F.transpose()) - Mat3Of<T>::Identity();
  }
  template <class T>
  Mat3Of<T> stress_of(const Mat3Of<T>& F) const {
    const Mat3Of<T> e = strain(F);
    return T(2 * lame_.mu) * e + (T(lame_.lambda) * e.trace()) * Mat3Of<T>::Identity();
  }
  Lame lame_;
  Mat9 tangent_;
};

}  // namespace

std::unique_ptr<Material> make_linear_material(const Lame& lame) { return std::make_unique<Linear>(lame); }

}  // namespace kt
