// Hooke's law in the small strain e = sym(F) - I: energy = mu e:e + lambda/2 tr(e)^2.
#include "models/fem/lane_material.hpp"

namespace kt {
namespace {

class Linear final : public LaneMaterial<Linear> {
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
  template <class T>
  Mat3Of<T> stress_of(const Mat3Of<T>& F) const {
    const Mat3Of<T> e = strain(F);
    return T(2 * lame_.mu) * e + (T(lame_.lambda) * e.trace()) * Mat3Of<T>::Identity();
  }
  Mat9 tangent(const Mat3&) const override { return tangent_; }
  /// mu ((g_a.g_b) I + g_b g_a^T) + lambda g_a g_b^T.
  void add_stiffness_to(const LaneStiffness& s) const {
    const auto& [F, definite, g, volume, blocks] = s;
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
  bool is_frame_indifferent() const override { return false; }

 private:
  template <class T>
  static Mat3Of<T> strain(const Mat3Of<T>& F) {
    return T(0.5) * (F + F.transpose()) - Mat3Of<T>::Identity();
  }
  Lame lame_;
  Mat9 tangent_;
};

}  // namespace

std::unique_ptr<Material> make_linear_material(const Lame& lame) { return std::make_unique<Linear>(lame); }

}  // namespace kt
