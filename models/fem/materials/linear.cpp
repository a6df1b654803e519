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
  Mat3 stress(const Mat3& F) const override {
    const Mat3 e = strain(F);
    return 2 * lame_.mu * e + lame_.lambda * e.trace() * Mat3::Identity();
  }
  Mat9 tangent(const Mat3&) const override { return tangent_; }
  bool is_frame_indifferent() const override { return false; }

 private:
  static Mat3 strain(const Mat3& F) { return 0.5 * (F + F.transpose()) - Mat3::Identity(); }
  Lame lame_;
  Mat9 tangent_;
};

}  // namespace

std::unique_ptr<Material> make_linear_material(const Lame& lame) { return std::make_unique<Linear>(lame); }

}  // namespace kt
