// Materials against their own energy, central differences, Hooke's law and rotations; the viscosity likewise.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "models/fem/lane_svd.hpp"
#include "models/fem/material.hpp"
#include "models/fem/viscosity.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kYoung = 1e4, kPoisson = 0.4;
constexpr double kDifferences = 1e-6;  // relative; central differences of step 1e-5 are good to 1e-9

Mat3 as_matrix(const VectorX& v) { return Eigen::Map<const Mat3>(v.data()); }
VectorX as_vector(const Mat3& m) { return Eigen::Map<const VectorX>(m.data(), 9); }
Mat3 deformed(double strain, unsigned seed) { return Mat3::Identity() + strain * as_matrix(random_vector(9, seed)); }
Mat3 turned(unsigned seed) {
  const VectorX v = random_vector(4, seed);
  return Eigen::Quaterniond(v[0], v[1], v[2], v[3]).normalized().toRotationMatrix();
}

/// The two smaller stretches nearly cancel: the rotation jumps, and its derivative is without bound.
bool rotation_is_unsure(const Mat3& F) {
  const Vec3 s = Eigen::JacobiSVD<Mat3>(F).singularValues();
  return s[1] + std::copysign(s[2], F.determinant()) < 1e-2 * s[0];
}

class MaterialTest : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Material> material_ = make_material(GetParam(), lame(kYoung, kPoisson));
};

std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const BackendInfo& b : material_backends()) out.push_back(b.name);
  return out;
}
INSTANTIATE_TEST_SUITE_P(All, MaterialTest, testing::ValuesIn(names()), [](const auto& p) { return p.param; });

/// Rest, small, 30 %, and inverted.
std::vector<Mat3> states() {
  std::vector<Mat3> out{Mat3::Identity(), turned(1)};
  for (unsigned s = 2; s < 8; ++s) out.push_back(turned(s) * deformed(0.3, s));
  Mat3 inverted = deformed(0.2, 9);
  inverted.col(1) *= -0.7;
  out.push_back(inverted);
  return out;
}

TEST_P(MaterialTest, StressIsTheGradientOfTheEnergy) {
  for (const Mat3& F : states()) {
    const auto energy = [&](const VectorX& f) { return VectorX{{material_->energy(as_matrix(f))}}; };
    const MatrixX gradient = central_differences(energy, as_vector(F), 1e-5);
    EXPECT_LE((gradient.transpose() - as_vector(material_->stress(F))).norm(), kDifferences * kYoung) << F;
  }
}

TEST_P(MaterialTest, TangentIsTheGradientOfTheStress) {
  for (const Mat3& F : states()) {
    const auto stress = [&](const VectorX& f) { return as_vector(material_->stress(as_matrix(f))); };
    const MatrixX gradient = central_differences(stress, as_vector(F), 1e-5);
    EXPECT_LE(relative_error(material_->tangent(F), gradient), kDifferences) << F;
  }
}

TEST_P(MaterialTest, IsHookesLawForSmallStrains) {
  const Lame l = lame(kYoung, kPoisson);
  EXPECT_LE(material_->stress(Mat3::Identity()).norm(), 1e-12 * kYoung);
  EXPECT_NEAR(material_->energy(Mat3::Identity()), 0, 1e-12 * kYoung);
  const Mat3 dF = as_matrix(random_vector(9, 3));
  const Mat3 e = 0.5 * (dF + dF.transpose());
  const Mat3 hooke = 2 * l.mu * e + l.lambda * e.trace() * Mat3::Identity();
  const VectorX dP = material_->tangent(Mat3::Identity()) * as_vector(dF);
  EXPECT_LE((dP - as_vector(hooke)).norm(), 1e-12 * hooke.norm());
}

TEST_P(MaterialTest, TurningGivesNoStress) {
  if (!material_->is_frame_indifferent()) GTEST_SKIP() << "the linear material does not claim it";
  for (unsigned s = 0; s < 20; ++s) {
    const Mat3 R = turned(s), F = deformed(0.3, s + 100);
    EXPECT_LE(material_->stress(R).norm(), 1e-12 * kYoung);
    EXPECT_LE((material_->stress(R * F) - R * material_->stress(F)).norm(), 1e-11 * kYoung);
  }
}

TEST_P(MaterialTest, DefiniteTangentIsPositiveAndExactAtRest) {
  EXPECT_LE(relative_error(material_->definite_tangent(turned(3)), material_->tangent(turned(3))), 1e-12);
  for (Mat3 F : states()) {
    F.row(0) *= 0.6;  // compressed: where exact tangents become indefinite
    const Mat9 exact = material_->tangent(F), definite = material_->definite_tangent(F);
    const Eigen::SelfAdjointEigenSolver<Mat9> before(exact), after(definite);
    const double scale = exact.norm();
    EXPECT_LE((exact - exact.transpose()).norm(), 1e-12 * scale);
    EXPECT_GE(after.eigenvalues().minCoeff(), -2e-12 * scale);
    if (GetParam() == "corotational" || GetParam() == "stvk") continue;  // part by part, not the nearest
    // The distance of the nearest one is the norm of the negative eigenvalues.
    EXPECT_NEAR((definite - exact).norm(), before.eigenvalues().cwiseMin(0).norm(), 1e-11 * scale);
  }
}

/// Blocks (a, b) of the contraction  volume sum_jl dP(ij, kl) g_a[j] g_b[l], in the order of the pairs a < b.
std::vector<Mat3> contracted(const Mat9& dP, const Eigen::Matrix3Xd& g, double volume) {
  std::vector<Mat3> out;
  for (int b = 0; b < g.cols(); ++b)
    for (int a = 0; a < b; ++a) {
      Mat3 block = Mat3::Zero();
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < 3; ++l) block += volume * g(j, a) * g(l, b) * dP.block<3, 3>(3 * j, 3 * l);
      out.push_back(block);
    }
  return out;
}

/// The same of four different F at once, and what a lane of it is.
struct FourStiffnesses {
  FourStiffnesses(const Material& material, const std::array<Mat3, 4>& F, bool definite, const Eigen::Matrix3Xd& g,
                  double volume)
      : blocks(static_cast<std::size_t>(g.cols() * (g.cols() - 1) / 2), LaneMat3::Zero()) {
    std::vector<LaneVec3> gradients;
    for (int a = 0; a < g.cols(); ++a) gradients.emplace_back(g.col(a).cast<Lanes>());
    LaneMat3 lanes;
    for (int lane = 0; lane < 4; ++lane) set_lane(lanes, lane, F[lane]);
    material.add_lane_stiffness(lanes, definite, gradients, volume, blocks);
  }
  double error(int lane, const std::vector<Mat3>& expected) const {
    double off = 0, size = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      off += (get_lane(blocks[i], lane) - expected[i]).squaredNorm();
      size += expected[i].squaredNorm();
    }
    return std::sqrt(off / size);
  }
  std::vector<LaneMat3> blocks;
};

TEST_P(MaterialTest, ElementStiffnessIsTheContractedTangent) {
  const Eigen::Matrix3Xd g = random_vector(30, 1).reshaped(3, 10);
  const auto shape = [&](unsigned seed) -> Mat3 {
    if (seed == 1) return Mat3::Identity();
    if (seed % 4 == 0) return turned(seed) * Vec3(1, 1, 1 + 0.01 * (seed % 5)).asDiagonal();  // equal stretches
    return turned(seed) * deformed(0.8, seed + 500);  // a third of them inverted
  };
  for (unsigned seed = 0; seed < 300; ++seed) {
    const std::array<Mat3, 4> F{shape(seed), shape(seed + 1), shape(seed + 2), shape(seed + 3)};
    for (const bool definite : {false, true}) {
      const FourStiffnesses four(*material_, F, definite, g, 0.3);
      for (int lane = 0; lane < 4; ++lane) {
        if (GetParam() == "corotational" && rotation_is_unsure(F[lane])) continue;
        const Mat9 dP = definite ? material_->definite_tangent(F[lane]) : material_->tangent(F[lane]);
        EXPECT_LE(four.error(lane, contracted(dP, g, 0.3)), 1e-10) << definite << ' ' << seed << '\n' << F[lane];
      }
    }
  }
}

TEST_P(MaterialTest, StressOfFourIsThatOfEach) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    LaneMat3 F;
    for (int lane = 0; lane < 4; ++lane) set_lane(F, lane, deformed(0.8, 4 * seed + static_cast<unsigned>(lane)));
    const LaneMat3 P = material_->lane_stress(F);
    for (int lane = 0; lane < 4; ++lane) {
      if (GetParam() == "corotational" && rotation_is_unsure(get_lane(F, lane))) continue;
      const Mat3 one = material_->stress(get_lane(F, lane));
      EXPECT_LE((get_lane(P, lane) - one).norm(), 1e-11 * (one.norm() + kYoung)) << seed;
    }
  }
}

/// Has what every material must have, and nothing more: as one begins that someone adds.
class Plain final : public Material {
 public:
  explicit Plain(const Material& material) : material_(material) {}
  double energy(const Mat3& F) const override { return material_.energy(F); }
  Mat3 stress(const Mat3& F) const override { return material_.stress(F); }
  Mat9 tangent(const Mat3& F) const override { return material_.tangent(F); }

 private:
  const Material& material_;
};

TEST_P(MaterialTest, EnergyStressAndTangentAreEnoughForAMaterial) {
  const Plain plain(*material_);
  const Eigen::Matrix3Xd g = random_vector(12, 1).reshaped(3, 4);
  const std::array<Mat3, 4> F{deformed(0.3, 1), deformed(0.3, 2), deformed(0.8, 3), turned(4)};
  LaneMat3 lanes;
  for (int lane = 0; lane < 4; ++lane) set_lane(lanes, lane, F[lane]);
  const LaneMat3 P = plain.lane_stress(lanes);
  for (const bool definite : {false, true}) {
    const FourStiffnesses four(plain, F, definite, g, 0.3);
    for (int lane = 0; lane < 4; ++lane) {
      EXPECT_EQ(get_lane(P, lane), plain.stress(F[lane]));
      const Mat9 dP = definite ? plain.definite_tangent(F[lane]) : plain.tangent(F[lane]);
      EXPECT_LE(four.error(lane, contracted(dP, g, 0.3)), 1e-13) << definite << ' ' << lane;
    }
  }
}

TEST(Rotation, IsThatOfTheSingularValueDecomposition) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    const Mat3 F = turned(seed) * deformed(seed % 2 ? 0.8 : 1e-3, seed + 500);
    const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = svd.matrixU().determinant() * svd.matrixV().determinant();
    const Mat3 expected = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    const Vec3 s = svd.singularValues();
    const double unsure = s[0] / std::max(1e-12, s[1] + sign * s[2]);  // how much the rotation depends on F's last bits
    EXPECT_LE((rotation_of(F) - expected).norm(), 1e-13 * unsure * unsure) << seed << '\n' << F;
  }
}

TEST(LaneSvd, GivesBackTheMatrixWithTwoRotationsAndTheSmallestLast) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    std::array<Mat3, 4> F{deformed(0.8, seed), turned(seed), Mat3(1e-8 * deformed(2, seed + 1)), deformed(1e-3, seed)};
    if (seed % 5 == 0) F[0].col(1) = F[0].col(2);         // rank 2
    if (seed % 7 == 0) F[1] = F[0].col(0) * F[0].row(1);  // rank 1
    if (seed % 7 == 1)
      F[1] = Vec3(1, 1, seed % 2) * Mat3(F[0]).row(1);  // rank 1, its second column roundoff along the first
    if (seed % 11 == 0) F[2] = turned(seed) * Vec3(2, 0, -1e-9).asDiagonal();  // graded
    if (seed % 13 == 0) F[3].setZero();
    if (seed % 17 == 0) F[3].setIdentity();
    LaneMat3 lanes;
    for (int lane = 0; lane < 4; ++lane) set_lane(lanes, lane, F[lane]);
    const LaneSvd svd = singular_values(lanes);
    for (int lane = 0; lane < 4; ++lane) {
      const Mat3 U = get_lane(svd.U, lane), V = get_lane(svd.V, lane);
      const Vec3 s = get_lane(svd.s, lane), expected = Eigen::JacobiSVD<Mat3>(F[lane]).singularValues();
      EXPECT_LE((U * s.asDiagonal() * V.transpose() - F[lane]).norm(), 1e-14 * F[lane].norm()) << seed << ' ' << lane;
      for (const Mat3& R : {U, V}) {
        EXPECT_LE((R.transpose() * R - Mat3::Identity()).norm(), 1e-14) << seed << ' ' << lane;
        EXPECT_GT(R.determinant(), 0);
      }
      EXPECT_LE((s.cwiseAbs() - expected).norm(), 1e-14 * expected[0]) << seed << ' ' << lane;
      EXPECT_GE(s[1], -1e-15 * s[0]);
    }
  }
}

TEST(NeoHookean, DefiniteStiffnessIsTheNearestForAnyStretchesAndPoissonsRatio) {
  const Eigen::Matrix3Xd g = random_vector(12, 1).reshaped(3, 4);
  int indefinite = 0;
  for (double poisson : {-0.95, -0.5, -0.2, 0.0, 0.3, 0.49}) {
    const auto material = make_material("neo_hookean", lame(kYoung, poisson));
    for (unsigned seed = 0; seed < 1000; ++seed) {
      Vec3 stretch = Vec3::Constant(0.8) + 1.2 * Vec3(random_vector(3, seed + 7000));  // -0.4 .. 2
      // Even compression: where, near nu = -1, the block of the stretches is indefinite and the rest is not.
      if (seed % 3 == 0) stretch = Vec3::Constant(0.7 + 0.3 * (seed % 100) / 100.0);
      const Mat3 F = turned(seed) * stretch.asDiagonal() * turned(seed + 3000);
      const FourStiffnesses four(*material, {F, Mat3::Identity(), F, F.transpose()}, true, g, 0.3);
      const Mat9 nearest = material->definite_tangent(F);
      indefinite += (nearest - material->tangent(F)).norm() > 1e-6 * nearest.norm();
      EXPECT_LE(four.error(0, contracted(nearest, g, 0.3)), 1e-9) << poisson << '\n' << F;
      EXPECT_LE(four.error(3, contracted(material->definite_tangent(F.transpose()), g, 0.3)), 1e-9) << poisson;
    }
  }
  EXPECT_GT(indefinite, 1000);
  EXPECT_LT(indefinite, 5800);  // both kinds
}

TEST(NeoHookean, DefiniteStiffnessIsDefiniteForCollapsedElements) {
  const auto material = make_material("neo_hookean", lame(kYoung, 0.45));
  const Eigen::Matrix3Xd g = random_vector(12, 1).reshaped(3, 4);
  const Vec3 a(1, 1, 1), b(1, 1, 0), c(0.3, 0.7, 0.2);
  const std::array<Mat3, 4> F{Mat3::Ones(), b * a.transpose(), a * c.transpose(), 1e-3 * b * c.transpose()};
  const FourStiffnesses four(*material, F, true, g, 0.3);
  for (int lane = 0; lane < 4; ++lane)
    EXPECT_LE(four.error(lane, contracted(material->definite_tangent(F[lane]), g, 0.3)), 1e-9) << lane;
}

TEST(NeoHookean, PushesOutOfInversionAndStVenantKirchhoffDoesNot) {
  // The force along a compressed axis, stretch s: pushes (P < 0) for the stable material at any s < 1, also inverted.
  const auto neo = make_material("neo_hookean", lame(kYoung, kPoisson));
  const auto stvk = make_material("stvk", lame(kYoung, kPoisson));
  for (double s : {0.8, 0.4, 0.1, 0.0, -0.3}) {
    const Mat3 F = Vec3(1, 1, s).asDiagonal();
    EXPECT_LT(neo->stress(F)(2, 2), 0) << s;
  }
  EXPECT_LT(stvk->stress(Vec3(1, 1, 0.8).asDiagonal().toDenseMatrix())(2, 2), 0);
  EXPECT_EQ(stvk->stress(Vec3(1, 1, 0).asDiagonal().toDenseMatrix())(2, 2), 0);  // the limit that it is known for
}

TEST(Viscosity, TangentsAreTheGradientsOfTheStress) {
  for (bool turns : {true, false}) {
    const Viscosity viscosity(lame(kYoung, kPoisson), 2e-3, turns);
    const Mat3 F = deformed(0.3, 1), rate = 5 * as_matrix(random_vector(9, 2));
    const auto of_rate = [&](const VectorX& r) { return as_vector(viscosity.stress(F, as_matrix(r))); };
    const auto of_shape = [&](const VectorX& f) { return as_vector(viscosity.stress(as_matrix(f), rate)); };
    const Eigen::Matrix3Xd g = random_vector(12, 3).reshaped(3, 4);
    std::vector<LaneVec3> gradients;
    for (int a = 0; a < 4; ++a) gradients.emplace_back(g.col(a).cast<Lanes>());
    const LaneMat3 lane_F = F.cast<Lanes>(), lane_rate = rate.cast<Lanes>();
    std::vector<LaneMat3> blocks(6, LaneMat3::Zero());
    viscosity.add_rate_blocks(lane_F, gradients, 0.3, blocks);
    const auto expected = contracted(central_differences(of_rate, as_vector(rate), 1e-4), g, 0.3);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_LE((get_lane(blocks[i], 2) - expected[i]).norm(), 1e-8 * expected[0].norm()) << i;

    std::vector<LaneMat3> above(6, LaneMat3::Zero()), below = above;
    viscosity.add_shape_blocks(lane_F, lane_rate, gradients, 0.3, above, below);
    const Mat9 by_shape = central_differences(of_shape, as_vector(F), 1e-5);
    const double tolerance = kDifferences * 5 * 2e-3 * kYoung;
    const auto expected_above = contracted(by_shape, g, 0.3), expected_below = contracted(by_shape.transpose(), g, 0.3);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_LE((get_lane(above[i], 1) - expected_above[i]).norm(), tolerance) << i;
      EXPECT_LE((get_lane(below[i], 1) - expected_below[i]).norm(), tolerance) << i;
    }
  }
}

TEST(Viscosity, TurningIsNotDamped) {
  const Viscosity viscosity(lame(kYoung, kPoisson), 2e-3, true);
  const Mat3 F = deformed(0.3, 1);
  Mat3 spin;
  spin << 0, -3, 2, 3, 0, -1, -2, 1, 0;
  EXPECT_LE(viscosity.stress(F, Mat3(spin * F)).norm(), 1e-13 * kYoung);
}

}  // namespace
}  // namespace kt
