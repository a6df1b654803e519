// The swing of a body under a push, against a beam's; the damping of steps against steps; and what steps as long as a
// refresh interval make of a body that is pushed on its way.
#include "haptics/predict/predict_swing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/global/global_simulation.hpp"
#include "haptics/session/session.hpp"
#include "models/model.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// A bar of 20 x 20 x 120 mm that stands on one end. Euler and Bernoulli: omega = 1.875^2 sqrt(E I / (rho A L^4)), and
/// of what its tip gives way the slowest vibration has 12 / 1.875^4.
TEST(Swing, OfABarIsThatOfABeam) {
  constexpr double kLength = 0.12, kWidth = 0.02, kYoung = 1e4, kDensity = 1000, kMass = 1.5, kStiffness = 2e-3;
  const Mesh mesh = kuhn_block(2, 2, 12, kWidth / 2);
  ModelOptions options{.young = kYoung,
                       .poisson = 0,
                       .density = kDensity,
                       .damping_mass = kMass,
                       .damping_stiffness = kStiffness,
                       .material = "linear",
                       .element = "tet10"};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) options.fixed_nodes.push_back(i);
  const auto body = make_model("fem", mesh, options);
  VectorX push = VectorX::Zero(body->mesh().x.size());
  int at_tip = 0;
  for (int i = 0; i < body->mesh().num_nodes(); ++i)
    if (body->mesh().x[3 * i + 2] > kLength - 1e-9) {
      push[3 * i] = 1;
      ++at_tip;
    }
  push /= at_tip;
  const auto swing = find_swing(*body, rest_state(*body), push);
  ASSERT_TRUE(swing);
  const double expected = 1.8751 * 1.8751 * std::sqrt(kYoung * kWidth * kWidth / 12 / kDensity) / (kLength * kLength);
  EXPECT_NEAR(swing->omega / expected, 1, 0.03);  // shear makes it slower by 2 %
  EXPECT_NEAR(swing->zeta, 0.5 * (kMass / swing->omega + kStiffness * swing->omega), 1e-3 * swing->zeta);
  EXPECT_NEAR(swing->share, 12 / std::pow(1.8751, 4), 0.02);
  options.fixed_nodes.clear();
  const auto loose = make_model("fem", mesh, options);
  EXPECT_FALSE(find_swing(*loose, rest_state(*loose), push));
}

/// Steps of x'' = -omega^2 x, until little is left: their decay over their own turning.
TEST(Swing, DampingOfStepsIsThatOfSteps) {
  for (const double turn : {0.05, 0.5, 2.0}) {
    constexpr int kSteps = 40;
    const double omega = 7, dt = turn / omega;
    std::complex<double> z = 1;  // x + i v / omega, apart from a sign
    double angle = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double x = (z.real() + turn * z.imag()) / (1 + turn * turn), v = z.imag() - turn * x;
      const std::complex<double> next(x, v);
      angle += std::abs(std::arg(next / z));
      z = next;
    }
    const double decay = -std::log(std::abs(z)) / angle;  // zeta / sqrt(1 - zeta^2)
    EXPECT_NEAR(backward_euler_damping(omega, dt), decay / std::hypot(1, decay), 1e-9) << turn;
  }
}

/// A bar that swings at 3 Hz, bent, whose tip is pushed on evenly; off: the velocities at the end of a few steps of an
/// interval, over those of 400 times as many in which the hold moves along.
double off_after_a_push(const std::string& integrator) {
  constexpr double kInterval = 1.0 / 30, kBent = 0.04, kSpeed = 0.02;
  constexpr int kIntervals = 4, kFine = 400;
  const Mesh mesh = kuhn_block(1, 1, 6, 0.02);
  ModelOptions options{
      .young = 1e4, .poisson = 0, .density = 1000, .damping_mass = 1, .damping_stiffness = 5e-3, .material = "linear"};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) options.fixed_nodes.push_back(i);
  const auto body = make_model("fem", mesh, options);
  const int tip = mesh.num_nodes() - 1;
  const Vec3 start = node(mesh.x, tip);
  ContactHold hold{.normal = -Vec3::UnitX(), .force = 1};  // the tool comes from there
  hold.moves.count = 1;
  hold.moves.node[0] = tip;
  hold.moves.weight[0] = 1;
  hold.point = start + kBent * Vec3::UnitX();
  GlobalSimulation settled(*body, make_integrator("implicit_euler", {.solver = "direct"}), 1);
  for (int i = 1; i <= 60; ++i) settled.advance(i * kInterval, {}, std::span(&hold, 1));
  State bent = settled.state();
  bent.t = 0;
  const auto run = [&](const std::string& name, int steps) {
    GlobalSimulation global(*body, make_integrator(name, {.solver = "direct"}), 1, bent);
    for (int i = 1; i <= steps; ++i) {
      const double t = kIntervals * kInterval * i / steps;
      hold.point = start + (kBent + kSpeed * t) * Vec3::UnitX();
      global.advance(t, {}, std::span(&hold, 1));
    }
    return global.state().v;
  };
  const VectorX truth = run("implicit_euler", kFine * kIntervals);
  return (run(integrator, kIntervals) - truth).norm() / truth.norm();
}

TEST(Swing, StagesOfAStepFindTheContactOnItsWay) {
  EXPECT_LT(off_after_a_push("sdirk2"), 0.1);
  EXPECT_LT(off_after_a_push("sdirk2"), 0.5 * off_after_a_push("implicit_euler"));
}

Scene swinging_scene() {
  Scene scene = small_scene();
  scene.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
  scene.object.model.type = "fem";
  scene.object.model.density = 1060;
  scene.object.fixed = {.below = {}, .box = std::array{Vec3(-1, -1, -1), Vec3(-0.03, 1, 1)}, .nodes = {}};
  scene.object.tetrahedralize = SceneTetrahedralize{.backend = {}, .max_volume = 1e-6, .max_edge = {}};
  scene.tool.radius = 0.006;
  scene.tool.path.press_drag =
      PressDrag{.at = std::array{0.03, 0.0}, .depth = 0.004, .press_time = 0.25, .speed = 0.02};
  return scene;
}

bool is_told(const Scene& scene) {
  const Session session(scene);
  for (const Prediction& p : session.predictions())
    if (p.failure == "swing") return p.message().find("sdirk2") != std::string::npos;
  return false;
}

TEST(Swing, IsToldOfAnOrganThatSticksOutAndOnlyOfSuch) {
  EXPECT_TRUE(is_told(swinging_scene()));
  Scene slow = swinging_scene();
  slow.tool.path.press_drag->press_time = 3;  // twenty swings
  slow.duration = 4;
  EXPECT_FALSE(is_told(slow));
  Scene held = swinging_scene();
  held.object.fixed = {.below = FixedBelow{"z", 0.15}, .box = {}, .nodes = {}};
  EXPECT_FALSE(is_told(held));
  Scene cured = swinging_scene();
  cured.global.integrator = "sdirk2";
  EXPECT_FALSE(is_told(cured));
}

}  // namespace
}  // namespace kt
