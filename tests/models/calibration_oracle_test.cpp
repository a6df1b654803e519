// What the calibrated network really does when it is pulled and sheared, by dense algebra on central differences.
#include "models/msd/calibration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cstdio>

#include "models/model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kYoung = 8e3, kPoisson = 0.25;

std::unique_ptr<DeformableModel> network(const Mesh& mesh) {
  return make_model("msd", mesh, {.young = kYoung, .poisson = kPoisson});
}

MatrixX stiffness_by_differences(const DeformableModel& model) {
  const auto force = [&](const VectorX& x) {
    VectorX out;
    model.force({0, x, VectorX::Zero(x.size())}, out);
    return out;
  };
  return -central_differences(force, model.mesh().x, 1e-8);
}

std::vector<Spring> calibrated(const Mesh& mesh, double young, double poisson) {
  std::vector<Spring> springs = make_springs(mesh);
  calibrate_springs(mesh, young, poisson, springs);
  return springs;
}

/// Stiffness seen at the dofs in `held` when the others are free: K_hh - K_hf K_ff^+ K_fh.
MatrixX condense(const MatrixX& K, const std::vector<int>& held, const std::vector<int>& free) {
  if (free.empty()) return K(held, held);
  Eigen::CompleteOrthogonalDecomposition<MatrixX> inner;
  inner.setThreshold(1e-6);  // rigid motions: the noise of the differences must not pass for stiffness
  const MatrixX relax = inner.compute(K(free, free)).solve(K(free, held));
  return K(held, held) - K(held, free) * relax;
}

/// Mean stress of a body whose surface follows a strain: surface forces times positions by volume (mean stress
/// theorem).
Mat3 mean_stress(const Mesh& mesh, const MatrixX& K, const Mat3& strain) {
  std::vector<int> surface, inner;
  std::vector<char> on_surface(mesh.num_nodes(), 0);
  for (const Triangle& t : mesh.triangles)
    for (int i : t) on_surface[i] = 1;
  for (int d = 0; d < mesh.x.size(); ++d) (on_surface[d / 3] ? surface : inner).push_back(d);
  VectorX u(surface.size());
  for (std::size_t k = 0; k < surface.size(); ++k) u[k] = strain.row(surface[k] % 3) * node(mesh.x, surface[k] / 3);
  const VectorX f = condense(K, surface, inner) * u;
  Mat3 moment = Mat3::Zero();
  for (std::size_t k = 0; k < surface.size(); ++k)
    moment.row(surface[k] % 3) += f[k] * node(mesh.x, surface[k] / 3).transpose();
  return moment / enclosed_volume(mesh);
}

TEST(NetworkElasticity, IsTheMeanStressOfTheStrainedModel) {
  const Mesh mesh = kuhn_block(3, 3, 3, 0.01);
  const auto C = network_elasticity(mesh, calibrated(mesh, kYoung, kPoisson));
  const MatrixX K = stiffness_by_differences(*network(mesh));
  constexpr int kRow[6] = {0, 1, 2, 1, 0, 0}, kColumn[6] = {0, 1, 2, 2, 2, 1};
  for (int e = 0; e < 6; ++e) {
    Mat3 strain = Mat3::Zero();
    strain(kRow[e], kColumn[e]) += 0.5;
    strain(kColumn[e], kRow[e]) += 0.5;
    const Mat3 stress = mean_stress(mesh, K, strain);
    for (int s = 0; s < 6; ++s)
      EXPECT_NEAR(stress(kRow[s], kColumn[s]), C(s, e), 1e-6 * kYoung) << s << " " << e;  // 1e-6: differences
  }
}

TEST(IsotropicElasticity, HasTheTextbookComplianceAndShear) {
  const Eigen::Matrix<double, 6, 6> C = isotropic_elasticity(kYoung, 0.3);
  const Eigen::Matrix<double, 6, 6> S = C.inverse();
  EXPECT_NEAR(S(0, 0) * kYoung, 1, 1e-12);
  EXPECT_NEAR(S(0, 1) * kYoung, -0.3, 1e-12);
  EXPECT_NEAR(C(5, 5), kYoung / 2.6, 1e-9);
}

TEST(IsotropicElasticity, OfTheNearestSolidIsTheSolidItself) {
  for (const double poisson : {-0.2, 0.0, 0.25, 0.49}) {
    const IsotropicSolid solid = nearest_isotropic(isotropic_elasticity(kYoung, poisson));
    EXPECT_NEAR(solid.young / kYoung, 1, 1e-12);
    EXPECT_NEAR(solid.poisson, poisson, 1e-12);
  }
  // Central forces that strain alike everywhere: Cauchy's relations, nu = 1/4.
  const Mesh mesh = kuhn_block(3, 3, 3, 0.01);
  EXPECT_NEAR(nearest_isotropic(network_elasticity(mesh, calibrated(mesh, kYoung, kPoisson))).poisson, 0.25, 0.02);
}

/// Young's modulus from a pull between two faces whose nodes keep their height and slide freely.
double pulled_young(const Mesh& mesh, double area, double length) {
  const MatrixX K = stiffness_by_differences(*network(mesh));
  std::vector<int> held, free;
  VectorX u(mesh.x.size());
  int count = 0;
  for (int d = 0; d < mesh.x.size(); ++d) {
    const double z = node(mesh.x, d / 3).z();
    const bool face = z < 1e-9 || z > length - 1e-9;
    (d % 3 == 2 && face ? held : free).push_back(d);
    if (d % 3 == 2 && face) u[count++] = z > 0.5 * length ? 1 : 0;
  }
  u.conservativeResize(count);
  return u.dot(condense(K, held, free) * u) * length / area;
}

TEST(Calibration, GivesABarTheYoungModulusItPromises) {
  const Mesh bar = kuhn_block(2, 2, 5, 0.01);
  std::vector<Spring> springs = make_springs(bar);
  const Calibration promised = calibrate_springs(bar, kYoung, kPoisson, springs);
  const double measured = pulled_young(bar, 4e-4, 0.05) / kYoung - 1;
  std::printf("bar pulled: %+.3f of Young's modulus, promised %+.3f; residual %.3f, shear %+.3f\n", measured,
              promised.young_error, promised.residual, promised.shear_error);
  // The six tetrahedra of a cell carry different stresses; free sides relax a little of them (2e-4 here).
  EXPECT_NEAR(measured, promised.young_error, 1e-3);
}

TEST(Calibration, ScalesExactlyWithYoungAndWithSize) {
  const Mesh mesh = kuhn_block(2, 2, 3, 0.01), twice = kuhn_block(2, 2, 3, 0.02);
  const std::vector<Spring> one = calibrated(mesh, kYoung, 0.3), four = calibrated(mesh, 4 * kYoung, 0.3),
                            large = calibrated(twice, kYoung, 0.3);
  for (std::size_t s = 0; s < one.size(); ++s) {
    EXPECT_GT(one[s].stiffness, 0);
    EXPECT_NEAR(four[s].stiffness / one[s].stiffness, 4, 1e-12);
    EXPECT_NEAR(large[s].stiffness / one[s].stiffness, 2, 1e-6);  // k = E L; the inner nodes' shift is 1e-9 relative
  }
}

// Edges along the axes (stiffness a), face diagonals (f) and body diagonals can only give C11 = a + 2 s, C12 = C66 = s
// and twelve couplings of s between normal and shear strain, s = f / 4, at best without body diagonals. Against C11 =
// 3, C12 = C66 = 1 (Poisson 1/4) least squares ends at s = 9 / 21: residual sqrt(27 / 7 + 9 / 7) / 6, shear -4 / 7.
TEST(Calibration, OfABlockIsNearTheBestThatItsEdgesAllowAndDoesNotDriftUnderRefinement) {
  const double best = std::sqrt(36.0 / 7) / 6;
  for (int n : {1, 2, 4, 8}) {
    const Mesh mesh = kuhn_block(n, n, n, 0.04 / n);
    std::vector<Spring> springs = make_springs(mesh);
    const Calibration c = calibrate_springs(mesh, kYoung, kPoisson, springs);
    std::printf("block of %d^3 cells: residual %.4f, Young %+.4f, shear %+.4f\n", n, c.residual, c.young_error,
                c.shear_error);
    EXPECT_GE(c.residual, best) << n;
    EXPECT_LE(c.residual, 1.05 * best) << n;
    EXPECT_NEAR(c.shear_error, -4.0 / 7, 0.01) << n;
  }
}

}  // namespace
}  // namespace kt
