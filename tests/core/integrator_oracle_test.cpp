// Integrators against dense algebra and the closed-form oscillator; order of convergence.
#include "core/global/integrator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "tests/support/linear_model.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-13;  // relative; well-conditioned solves of a dozen unknowns

struct Body {
  MatrixX mass = random_positive_definite(12, 1), damping = random_positive_definite(12, 2),
          stiffness = 50 * random_positive_definite(12, 3);
  State state{0.5, random_vector(12, 4), random_vector(12, 5)};
  VectorX external = random_vector(12, 6);
  LinearModel model() const { return {mass, damping, stiffness}; }
};

TEST(SymplecticEuler, StepsAsTheFormulaSaysAlsoWithAFullMassMatrix) {
  const Body b;
  const double dt = 0.01;
  State state = b.state;
  make_integrator("symplectic_euler")->step(b.model(), b.external, dt, state);
  const VectorX force = b.external - b.stiffness * b.state.x - b.damping * b.state.v;
  const VectorX v = b.state.v + dt * b.mass.llt().solve(force);
  EXPECT_LE(relative_error(state.v, v), kRoundoff);
  EXPECT_LE(relative_error(state.x, b.state.x + dt * v), kRoundoff);
  EXPECT_EQ(state.t, 0.51);
}

TEST(ImplicitEuler, SolvesTheBackwardEquationsOfALinearBody) {
  const Body b;
  const double dt = 0.1;
  State state = b.state;
  make_integrator("implicit_euler")->step(b.model(), b.external, dt, state);
  // Backward Euler: M (v+ - v) = dt (f(x+, v+) + external), x+ = x + dt v+. Checked by its residual.
  const VectorX force = b.external - b.stiffness * state.x - b.damping * state.v;
  EXPECT_LE(relative_error(b.mass * (state.v - b.state.v), dt * force), 1e-12);  // differences of v cost a digit
  EXPECT_LE(relative_error(state.x, b.state.x + dt * state.v), kRoundoff);
}

TEST(Integrators, ReuseNothingStaleWhenTheStepLengthChanges) {
  const Body b;
  for (const BackendInfo& backend : integrator_backends()) {
    State once = b.state, again = b.state;
    const auto used = make_integrator(backend.name);
    used->step(b.model(), b.external, 0.03, again);
    again = b.state;
    used->step(b.model(), b.external, 0.01, again);
    make_integrator(backend.name)->step(b.model(), b.external, 0.01, once);
    EXPECT_EQ(once, again) << backend.name;
  }
}

/// (x, v / omega) of x'' = -omega^2 x - 2 zeta omega x' from x = 1, v = 0.
Eigen::Vector2d oscillator_at(double t, double omega, double zeta) {
  const double damped = omega * std::sqrt(1 - zeta * zeta), s = zeta * omega / damped;
  const double decay = std::exp(-zeta * omega * t), c = std::cos(damped * t), sn = std::sin(damped * t);
  return decay * Eigen::Vector2d(c + s * sn, -omega / damped * sn);
}

double oscillator_error(const std::string& integrator, double dt) {
  constexpr double kOmega = 6, kZeta = 0.1;
  const LinearModel model = oscillator(kOmega, kZeta);
  State state{0, VectorX::Ones(3), VectorX::Zero(3)};
  const auto stepper = make_integrator(integrator);
  for (int i = 0, steps = static_cast<int>(std::lround(1 / dt)); i < steps; ++i)
    stepper->step(model, VectorX::Zero(3), dt, state);
  return (Eigen::Vector2d(state.x[1], state.v[1] / kOmega) - oscillator_at(1, kOmega, kZeta)).norm();
}

TEST(Integrators, ConvergeToTheClosedFormOscillatorWithTheirOrder) {
  for (const BackendInfo& backend : integrator_backends()) {
    if (!make_integrator(backend.name)->is_dynamic()) continue;
    const bool second = backend.name == "sdirk2" || backend.name == "implicit_midpoint";
    const double coarse = oscillator_error(backend.name, 1.0 / 1000), fine = oscillator_error(backend.name, 1.0 / 2000);
    const double order = std::log2(coarse / fine);
    std::printf("%s: error %.2e at 1 ms, order %.3f\n", backend.name.c_str(), coarse, order);
    EXPECT_LE(coarse, second ? 2e-5 : 0.02) << backend.name;  // (omega dt)^2 omega t / 12 and omega^2 dt / 2 = 0.018
    EXPECT_NEAR(order, second ? 2 : 1, 0.1) << backend.name;
  }
}

}  // namespace
}  // namespace kt
