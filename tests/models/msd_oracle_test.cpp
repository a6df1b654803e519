// The mass-spring-damper network against its own energy, central differences and the laws of mechanics.
#include <gtest/gtest.h>

#include <cstdio>
#include <set>

#include "core/global/integrator.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kStiffness = 40, kDamper = 0.3, kEdge = 0.01;
constexpr double kDifferences = 1e-6;  // relative; the differences themselves are good to 1e-9
constexpr double kRoundoff = 1e-12;    // relative to the largest term of the sum

std::unique_ptr<DeformableModel> network(double damper, double damping_mass = 0, std::vector<int> fixed = {},
                                         double least_volume = 0.7) {
  return make_model("msd", kuhn_block(2, 2, 2, kEdge),
                    {.damping_mass = damping_mass,
                     .stiffness = kStiffness,
                     .damper = damper,
                     .least_volume = least_volume,
                     .fixed_nodes = fixed});
}

double elastic_energy(const Mesh& mesh, const VectorX& x) {
  std::set<std::pair<int, int>> edges;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (int i : t)
      for (int j : t)
        if (i < j) edges.emplace(i, j);
  double energy = 0;
  for (const auto& [i, j] : edges) {
    const double stretch = (node(x, j) - node(x, i)).norm() - (node(mesh.x, j) - node(mesh.x, i)).norm();
    energy += 0.5 * kStiffness * stretch * stretch;
  }
  return energy;
}

TEST(MsdForce, IsMinusTheGradientOfTheElasticEnergy) {
  const auto model = network(0, 0, {}, 0);  // springs alone
  for (double strain : {0.0, 0.3}) {
    const State s = shaken(*model, strain * kEdge, 1);
    const auto energy = [&](const VectorX& x) { return VectorX{{elastic_energy(model->mesh(), x)}}; };
    const VectorX gradient = central_differences(energy, s.x, 1e-7).transpose();
    const double scale = kStiffness * kEdge * 0.3;
    EXPECT_LE((force(*model, s) + gradient).norm(), kDifferences * scale) << strain;
  }
}

TEST(MsdForce, OfOneStretchedSpringIsTheHandValue) {
  const auto model = make_model("msd", one_tetrahedron(1), {.stiffness = 10, .damper = 2.0});
  State s = rest_state(*model);
  s.x[3] = 1.5;  // node 1 along x: the spring 0-1 is half a metre longer, and the two others of node 1
  s.v[3] = 0.25;
  const double length = std::sqrt(1.5 * 1.5 + 1), pull = 10 * (length - std::sqrt(2.0)) + 2 * 0.25 * 1.5 / length;
  const VectorX f = force(*model, s);
  EXPECT_NEAR(f[0], 10 * 0.5 + 2 * 0.25, kRoundoff);
  EXPECT_NEAR(f[3], -f[0] - 2 * pull * 1.5 / length, 10 * kRoundoff);
  EXPECT_NEAR(f[4], pull / length, 10 * kRoundoff);
}

TEST(MsdTangent, IsTheDerivativeOfTheForceAtRestAndUnderLargeDeformation) {
  const std::vector<int> fixed{0, 1, 2};
  for (double damper : {0.0, kDamper})
    for (double damping_mass : {0.0, 5.0})
      for (double strain : {0.0, 0.05, 0.3}) {
        const auto model = network(damper, damping_mass, fixed);
        const State s = shaken(*model, strain * kEdge, 7);
        const Tangent t = model->tangent(s, TangentKind::exact);
        const auto of_x = [&](const VectorX& x) { return force(*model, {0, x, s.v}); };
        const auto of_v = [&](const VectorX& v) { return force(*model, {0, s.x, v}); };
        const MatrixX dfdx = central_differences(of_x, s.x, 1e-7), dfdv = central_differences(of_v, s.v, 1e-3);
        EXPECT_LE(relative_error(t.dfdx, dfdx), kDifferences) << damper << " " << damping_mass << " " << strain;
        EXPECT_LE(relative_error(t.dfdv, dfdv), kDifferences) << damper << " " << damping_mass << " " << strain;
      }
}

TEST(MsdDefiniteTangent, IsPositiveSemidefiniteWhereTheExactOneIsNot) {
  const auto model = network(kDamper, 5);
  State s = shaken(*model, 0.3 * kEdge, 3);
  s.x *= 0.7;  // compressed
  const auto smallest = [](const SparseMatrix& minus_k) {
    const MatrixX k = -MatrixX(minus_k);
    EXPECT_EQ(k, k.transpose());
    return symmetric_eigenvalues(k)[0];
  };
  State still = s;
  still.v.setZero();
  EXPECT_LT(smallest(model->tangent(still, TangentKind::exact).dfdx), -1);
  const Tangent definite = model->tangent(s, TangentKind::definite);
  EXPECT_GE(smallest(definite.dfdx), -kRoundoff * kStiffness);
  EXPECT_GE(smallest(definite.dfdv), -kRoundoff * kStiffness);
}

TEST(MsdDefiniteTangent, EqualsTheExactOneWhereEverySpringIsStretchedAndAtRest) {
  const auto model = network(kDamper, 5);
  State s = shaken(*model, 0.05 * kEdge, 3);
  s.x *= 1.5;
  s.v.setZero();
  const Tangent definite = model->tangent(s, TangentKind::definite), exact = model->tangent(s, TangentKind::exact);
  EXPECT_LE(relative_error(definite.dfdx, exact.dfdx), kRoundoff);
  EXPECT_LE(relative_error(definite.dfdv, exact.dfdv), kRoundoff);
}

TEST(MsdForce, VanishesAtRestAndUnderRigidMotion) {
  const auto model = network(kDamper);
  EXPECT_EQ(force(*model, rest_state(*model)), VectorX::Zero(model->mesh().x.size()));
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vec3 spin(30, 20, -10);
  State s = rest_state(*model);
  for (int i = 0; i < model->mesh().num_nodes(); ++i) {
    node(s.x, i) = turn * Vec3(node(s.x, i)) + Vec3(0.1, 0.2, 0.3);
    node(s.v, i) = spin.cross(Vec3(node(s.x, i))) + Vec3(1, 2, 3);
  }
  const double scale = kStiffness * 0.4 + kDamper * spin.norm() * 0.4;  // positions up to 0.4 m cancel in d and d'
  EXPECT_LE(force(*model, s).lpNorm<Eigen::Infinity>(), 10 * kRoundoff * scale);
}

struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

Momentum momentum(const DeformableModel& model, const State& s) {
  Momentum out;
  const VectorX p = model.mass() * s.v;
  for (int i = 0; i < s.x.size() / 3; ++i) {
    out.linear += node(p, i);
    out.angular += Vec3(node(s.x, i)).cross(Vec3(node(p, i)));
  }
  return out;
}

TEST(FreeBody, KeepsItsMomentum) {
  const auto model = network(kDamper);
  for (const BackendInfo& backend : integrator_backends()) {
    if (!make_integrator(backend.name)->is_dynamic()) continue;
    State s = shaken(*model, 0.3 * kEdge, 11);
    s.v += VectorX::Ones(s.v.size());
    const Momentum begin = momentum(*model, s);
    const auto stepper = make_integrator(backend.name, {.convergence = 1e-15});
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i) stepper->step(*model, VectorX::Zero(s.x.size()), 1e-4, s);
    const Momentum end = momentum(*model, s);
    const double linear = (end.linear - begin.linear).norm() / begin.linear.norm() / kSteps;
    const double angular = (end.angular - begin.angular).norm() / begin.angular.norm() / kSteps;
    std::printf("%s: momentum error a step %.1e linear, %.1e angular\n", backend.name.c_str(), linear, angular);
    EXPECT_LE(linear, kRoundoff) << backend.name;
    // Central forces and x+ = x + dt v+ keep the angular momentum of an explicit step; a linearized step only to O(dt).
    EXPECT_LE(angular, backend.name == "symplectic_euler" ? kRoundoff : 1e-2) << backend.name;
  }
}

TEST(MsdMass, SumsToDensityTimesVolumeInEachDirection) {
  const auto model = make_model("msd", kuhn_block(3, 2, 2, kEdge), {.density = 1100, .stiffness = 1.0});
  const double expected = 1100 * 12 * std::pow(kEdge, 3);
  const MatrixX mass = model->mass();
  for (int c = 0; c < 3; ++c) {
    VectorX along = VectorX::Zero(mass.rows());
    for (int i = c; i < along.size(); i += 3) along[i] = 1;
    EXPECT_NEAR(along.dot(mass * along), expected, kRoundoff * expected);
  }
  EXPECT_GT(mass.diagonal().minCoeff(), 0);
  EXPECT_EQ(mass, MatrixX(mass.diagonal().asDiagonal()));
}

TEST(MsdForce, OfACollapsedSpringIsFiniteAndPushesItsEndsApart) {
  const auto model = make_model("msd", one_tetrahedron(1), {.stiffness = 10, .damper = 2.0});
  State s = rest_state(*model);
  node(s.x, 1) = node(s.x, 0);
  const VectorX f = force(*model, s);
  EXPECT_TRUE(f.allFinite());
  EXPECT_GE((node(f, 1) - node(f, 0)).norm(), 2 * 10 * 0.9);
  EXPECT_TRUE(MatrixX(model->tangent(s, TangentKind::definite).dfdx).allFinite());
}

}  // namespace
}  // namespace kt
