// Hooke's law in a frame that turns with the element, F = R S:  energy = mu |F - R|^2 + lambda/2 (tr(S) - 3)^2.
// The tangent includes the turning of R, so that it is the exact derivative.
#include <Eigen/LU>

#include "models/fem/material.hpp"

namespace kt {
namespace {

class Corotational final : public Material {
 public:
  explicit Corotational(const Lame& lame) : lame_(lame) {}
  double energy(const Mat3& F) const override {
    const Mat3 R = rotation_of(F);
    const double volumetric = (R.transpose() * F).trace() - 3;
    return lame_.mu * (F - R).squaredNorm() + 0.5 * lame_.lambda * volumetric * volumetric;
  }
  Mat3 stress(const Mat3& F) const override {
    const Mat3 R = rotation_of(F);
    return 2 * lame_.mu * (F - R) + lame_.lambda * ((R.transpose() * F).trace() - 3) * R;
  }
  Mat9 tangent(const Mat3& F) const override {
    const Mat3 R = rotation_of(F);
    const Mat3 S = R.transpose() * F;
    // dR = R [w]x with (tr(S) I - S) w = axial vector of R^T dF - dF^T R.
    const Mat3 turning = (S.trace() * Mat3::Identity() - S).inverse();
    const double spherical = lame_.lambda * (S.trace() - 3) - 2 * lame_.mu;  // factor of dR
    Mat9 out = lame_.lambda * flat(R) * flat(R).transpose();
    out.diagonal().array() += 2 * lame_.mu;
    for (int c = 0; c < 9; ++c) {
      const Vec3 u = R.row(c % 3);  // R^T dF = u e_j^T with j = c / 3
      const Vec3 w = turning * Vec3::Unit(c / 3).cross(u);
      Mat3 dR;
      for (int i = 0; i < 3; ++i) dR.row(i) = -w.cross(Vec3(R.row(i)));  // R [w]x
      out.col(c) += spherical * flat(dR);
    }
    return out;
  }
  /// With R held: what Hooke's law gives in the turned frame, definite at any F (Mueller and Gross 2004).
  Mat9 definite_tangent(const Mat3& F) const override {
    const Mat3 R = rotation_of(F);
    Mat9 out = lame_.lambda * flat(R) * flat(R).transpose();
    for (int c = 0; c < 9; ++c) {
      const Vec3 u = R.row(c % 3);
      const Mat3 turned = u * Vec3::Unit(c / 3).transpose();  // R^T dF
      out.col(c) += lame_.mu * flat(Mat3(R * (turned + turned.transpose())));
    }
    return out;
  }
  /// 2 mu (g_a.g_b) I + lambda h_a h_b^T - s [h_a]x T [h_b]x with h = R g, s the factor of dR and T its turning, both
  /// in world axes. Of the definite one s T is what it is at rest, -mu I.
  void add_stiffness(const Mat3& F, bool definite, const Gradients& g, double volume,
                     Eigen::Ref<MatrixX> stiffness) const override {
    const Mat3 R = rotation_of(F), S = F * R.transpose();  // F = S R: the left stretch
    Mat3 turning = -lame_.mu * Mat3::Identity();
    if (!definite)
      turning = (lame_.lambda * (S.trace() - 3) - 2 * lame_.mu) * (S.trace() * Mat3::Identity() - S).inverse();
    for (Eigen::Index b = 0; b < g.cols(); ++b) {
      const Vec3 gb = volume * g.col(b), hb = R * gb;
      const Mat3 turned = turning * cross_matrix(hb);
      for (Eigen::Index a = 0; a <= b; ++a) {
        const Vec3 ha = R * g.col(a);
        Mat3 block = (lame_.lambda * ha) * hb.transpose();
        for (int i = 0; i < 3; ++i) block.col(i) -= ha.cross(Vec3(turned.col(i)));
        block.diagonal().array() += 2 * lame_.mu * g.col(a).dot(gb);
        stiffness.block<3, 3>(3 * a, 3 * b) += block;
        if (a != b) stiffness.block<3, 3>(3 * b, 3 * a) += block.transpose();
      }
    }
  }

 private:
  Lame lame_;
};

}  // namespace

std::unique_ptr<Material> make_corotational_material(const Lame& lame) { return std::make_unique<Corotational>(lame); }

}  // namespace kt
