// St. Venant-Kirchhoff: Hooke's law in the Green strain E = (F^T F - I)/2. Its stress falls again below 58 % of the
// rest length and is zero at zero length: crushed elements stay crushed.
#include "models/fem/material.hpp"

namespace kt {
namespace {

class StVenantKirchhoff final : public Material {
 public:
  explicit StVenantKirchhoff(const Lame& lame) : lame_(lame) {}
  double energy(const Mat3& F) const override {
    const Mat3 E = green(F);
    return lame_.mu * E.squaredNorm() + 0.5 * lame_.lambda * E.trace() * E.trace();
  }
  Mat3 stress(const Mat3& F) const override { return F * second(F); }
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

 private:
  static Mat3 green(const Mat3& F) { return 0.5 * (F.transpose() * F - Mat3::Identity()); }
  Mat3 second(const Mat3& F) const {
    const Mat3 E = green(F);
    return 2 * lame_.mu * E + lame_.lambda * E.trace() * Mat3::Identity();
  }
  Lame lame_;
};

}  // namespace

std::unique_ptr<Material> make_stvk_material(const Lame& lame) { return std::make_unique<StVenantKirchhoff>(lame); }

}  // namespace kt
