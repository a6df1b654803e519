// Hooke's law in a frame that turns with the element, F = R S:  energy = mu |F - R|^2 + lambda/2 (tr(S) - 3)^2.
// The tangent includes the turning of R, so that it is the exact derivative.
#include <Eigen/LU>

#include "models/fem/lane_material.hpp"

namespace kt {
namespace {

class Corotational final : public LaneMaterial<Corotational> {
 public:
  explicit Corotational(const Lame& lame) : lame_(lame) {}
  double energy(const Mat3& F) const override {
    const Mat3 R = rotation_of(F);
    const double volumetric = (R.transpose() * F).trace() - 3;
    return lame_.mu * (F - R).squaredNorm() + 0.5 * lame_.lambda * volumetric * volumetric;
  }
  template <class T>
  Mat3Of<T> stress_of(const Mat3Of<T>& F) const {
    const Mat3Of<T> R = rotation_of(F);
    const T trace = R.col(0).dot(F.col(0)) + R.col(1).dot(F.col(1)) + R.col(2).dot(F.col(2));
    return T(2 * lame_.mu) * (F - R) + (T(lame_.lambda) * (trace - T(3))) * R;
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
  void add_stiffness_to(const LaneStiffness& s) const {
    const auto& [F, definite, g, volume, blocks] = s;
    const LaneMat3 R = rotation_of(F);
    LaneMat3 turning = Lanes(-lame_.mu) * LaneMat3::Identity();
    if (!definite) {
      const LaneMat3 S = F * R.transpose();  // F = S R: the left stretch
      const Lanes sum = S.trace();
      const LaneMat3 others = sum * LaneMat3::Identity() - S, cof = cofactor(others);
      const Lanes factor = Lanes(lame_.lambda) * (sum - 3) - 2 * lame_.mu;
      turning = (factor / others.col(0).dot(cof.col(0))) * cof;  // its inverse: symmetric
    }
    const PerNode h = per_node(R, g);
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 hb = volume * h[b], lambda_hb = Lanes(lame_.lambda) * hb,
                     mu_gb = Lanes(2 * lame_.mu) * volume * g[b];
      LaneMat3 turned;  // T [h_b]x
      for (int i = 0; i < 3; ++i) turned.row(i) = LaneVec3(turning.col(i)).cross(hb);
      for (std::size_t a = 0; a < b; ++a, ++block) {
        const Lanes along = g[a].dot(mu_gb);
        for (int i = 0; i < 3; ++i) {
          block->col(i) += lambda_hb[i] * h[a] - h[a].cross(LaneVec3(turned.col(i)));
          (*block)(i, i) += along;
        }
      }
    }
  }

 private:
  Lame lame_;
};

}  // namespace

std::unique_ptr<Material> make_corotational_material(const Lame& lame) { return std::make_unique<Corotational>(lame); }

}  // namespace kt
