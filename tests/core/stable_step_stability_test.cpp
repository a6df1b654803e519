// The stability limit of explicit steps, by simulation just below and above it and by dense eigenvalues.
#include <gtest/gtest.h>

#include "core/global/global_simulation.hpp"
#include "core/linear/dense/dense_solvers.hpp"
#include "core/linear/free_dofs.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/linear_model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

double size_after(const DeformableModel& model, State state, double dt, int steps) {
  const auto stepper = make_integrator("symplectic_euler");
  const VectorX no_force = VectorX::Zero(state.x.size());
  for (int i = 0; i < steps; ++i) stepper->step(model, no_force, dt, state);
  return (state.x - model.mesh().x).norm() + state.v.norm();
}

double stable_step(const FastestMode& mode) { return make_integrator("symplectic_euler")->stable_step(mode); }

TEST(StableStep, SeparatesDecayFromGrowthForEveryDampingRatio) {
  constexpr double kOmega = 40;
  for (double zeta : {0.0, 0.01, 0.3, 1.0, 3.0, 30.0}) {
    const LinearModel model = oscillator(kOmega, zeta);
    const double limit = stable_step({kOmega, zeta});
    const State start{0, VectorX::Ones(3), VectorX::Ones(3)};
    EXPECT_LE(size_after(model, start, 0.99 * limit, 1000), 500) << zeta;  // undamped: a long ellipse, no growth
    EXPECT_GE(size_after(model, start, 1.01 * limit, 1000), 1e6) << zeta;
  }
  EXPECT_TRUE(std::isinf(stable_step({0, 0})));
  EXPECT_TRUE(std::isinf(make_integrator("implicit_euler")->stable_step({kOmega, 0})));
}

TEST(FastestMode, OfAnOscillatorIsTheOscillator) {
  for (double zeta : {0.0, 0.2, 5.0}) {
    const LinearModel model = oscillator(7, zeta);
    const FastestMode mode = fastest_mode(model, rest_state(model));
    EXPECT_NEAR(mode.omega, 7, 1e-12);
    EXPECT_NEAR(mode.zeta, zeta, 1e-12);
  }
}

TEST(FastestMode, OfDampersWithoutSpringsLimitsTheStepByTheDampers) {
  const MatrixX one = MatrixX::Identity(3, 3), none = MatrixX::Zero(3, 3);
  const LinearModel damped(one, 4 * one, none), free(one, none, none), held(one, one, one, {0});
  EXPECT_NEAR(stable_step(fastest_mode(damped, rest_state(damped))), 0.5, 1e-12);  // v+ = (1 - 4 dt) v
  EXPECT_TRUE(std::isinf(stable_step(fastest_mode(free, rest_state(free)))));
  EXPECT_TRUE(std::isinf(stable_step(fastest_mode(held, rest_state(held)))));
}

/// Spectral radius of one step of symplectic Euler on (x, v).
double growth(const MatrixX& M, const MatrixX& D, const MatrixX& K, double h) {
  const Eigen::Index n = M.rows();
  const MatrixX one = MatrixX::Identity(n, n), m = M.inverse();
  const MatrixX vx = -h * m * K, vv = one - h * m * D;
  MatrixX step(2 * n, 2 * n);
  step << one + h * vx, h * vv, vx, vv;
  return spectral_radius(step);
}

/// Bisection for the step where the growth passes one.
double true_limit(const MatrixX& M, const MatrixX& D, const MatrixX& K) {
  double stable = 0, unstable = 1;
  while (growth(M, D, K, unstable) < 1 + 1e-9) unstable *= 2;
  for (int i = 0; i < 40; ++i)
    (growth(M, D, K, 0.5 * (stable + unstable)) < 1 + 1e-9 ? stable : unstable) = 0.5 * (stable + unstable);
  return stable;
}

TEST(FastestMode, IsTheBindingOneOfRandomDampersByDenseEigenvalues) {
  constexpr int n = 15;
  for (unsigned seed = 0; seed < 12; ++seed) {
    // A few strong dampers in random directions: the fastest mode of the springs is seldom the binding one.
    MatrixX D = MatrixX::Zero(n, n);
    for (unsigned k = 0; k < 3; ++k) {
      const VectorX u = random_vector(n, 100 + 10 * seed + k);
      D += std::pow(4.0, seed % 6) * u * u.transpose();
    }
    const MatrixX M = random_positive_definite(n, seed), K = 300 * random_positive_definite(n, 50 + seed);
    const LinearModel model(M, D, K);
    const double limit = stable_step(fastest_mode(model, rest_state(model)));
    EXPECT_NEAR(limit / true_limit(M, D, K), 1, 1e-6) << seed;
  }
}

TEST(FastestMode, OfADampedBlockIsWithinAPerCentOfDenseEigenvaluesAndNeverBelow) {
  const Mesh mesh = kuhn_block(4, 4, 4, 0.01);
  for (double damping : {0.0, 1e-4, 1e-2}) {
    const auto model = make_model(
        "msd", mesh, {.damping_mass = 3, .damping_stiffness = damping, .fixed_nodes = nodes_below(mesh, 1e-6)});
    const double h = stable_step(fastest_mode(*model, rest_state(*model)));
    const FreeDofs dofs = make_free_dofs(mesh.num_nodes(), model->fixed_nodes());
    const Tangent t = model->tangent(rest_state(*model), TangentKind::exact);
    const MatrixX sum = -gather(dofs, SparseMatrix(h * h * t.dfdx + 2 * h * t.dfdv));
    const double highest = generalized_eigenvalues(sum, gather(dofs, model->mass())).maxCoeff();
    EXPECT_GE(highest, 4 * (1 - 1e-9)) << damping;  // 4 at the true limit
    EXPECT_LE(highest, 4 * 1.01) << damping;
  }
}

TEST(GlobalSimulation, KeepsAStronglyDampedBodyStableUnderExplicitSteps) {
  const Mesh mesh = kuhn_block(2, 2, 2, 0.01);
  const auto model =
      make_model("msd", mesh, {.damping_stiffness = 0.02, .fixed_nodes = nodes_below(mesh, 1e-6)});  // zeta about 10
  GlobalSimulation simulation(*model, make_integrator("symplectic_euler"), 0.01);
  ContactSample poke;
  poke.moves = {{26, 25, 23}, Vec3(1, 0, 0)};
  poke.impulse = Vec3(0, 0, -1e-4);
  simulation.advance(0.5, {&poke, 1});
  EXPECT_LE((simulation.state().x - mesh.x).norm(), 0.01);
  EXPECT_LE(simulation.state().v.norm(), 0.1);
}

}  // namespace
}  // namespace kt
