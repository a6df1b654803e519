// Bodies that touch one another, from the scene to the force on the hand.
#include <gtest/gtest.h>

#include "bench/pressed_bodies.hpp"
#include "haptics/press.hpp"
#include "haptics/session.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.005, kThick = 2 * kCell, kGap = 2e-4;  // [m]
constexpr double kDepth = 0.003, kRadius = 0.01;

Mesh stack() {
  const Mesh block = kuhn_block(6, 6, 2, kCell);
  return joined({block, placed(block, {0, 0, kThick + kGap})});
}

/// A sphere pressed onto the middle, then held, or dragged at `speed`.
Scene press_scene(double speed = 0) {
  Scene scene;
  scene.title = "test";
  scene.duration = 0.3;
  scene.object.mesh = "stack";
  scene.object.gravity = {0, 0, -9.81};
  scene.object.fixed.below->fraction = 0.01;
  scene.object.model.type = "fem";
  scene.object.model.young = 2e4;
  scene.tool.radius = kRadius;
  scene.tool.path.press_drag =
      PressDrag{.at = std::array<double, 2>{0.0135, 0.014}, .depth = kDepth, .press_time = 0.15, .speed = speed};
  scene.contact.mu_static = scene.contact.mu_kinetic = 0.3;
  scene.collision.backend = "brute_force";
  scene.global.integrator = "newton_euler";
  scene.local.reducer = "condensed";
  return scene;
}

Scene touching_scene(double speed = 0) {
  Scene scene = press_scene(speed);
  scene.global.self_contact = SceneSelfContact{.mu = 0.5};
  return scene;
}

/// Mean normal force while the tool is held [N].
double held_force(const SessionResult& run) {
  double sum = 0;
  for (std::size_t i = 250; i < 300; ++i) sum += run.frames.at(i).f_n / 50;
  return sum;
}

TEST(SelfContactSession, AStackGivesWayAsTheBlockThatItWouldBeInOnePiece) {
  const double stacked = held_force(Session(touching_scene(), stack()).run());
  const double whole = held_force(Session(press_scene(), kuhn_block(6, 6, 4, kCell)).run());
  const double upper = held_force(Session(press_scene(), kuhn_block(6, 6, 2, kCell)).run());
  EXPECT_NEAR(stacked / whole, 1, 0.05);
  EXPECT_GT(upper / whole, 1.2);  // alone on the table it resists more: two springs in a row are softer than one
}

TEST(SelfContactSession, ForceIsThatOfTheWholeBodyInEquilibrium) {
  const Scene scene = touching_scene();
  Session session(scene, stack());
  const SessionResult run = session.run();
  SelfContact contact(session.model(), {.mu = 0.5});
  const TouchingModel touching(session.model(), contact, session.start(), 1);
  const Vec3 end = run.frames.back().tool;
  const PressResult truth = press(touching, session.start(), {end + Vec3(0, 0, kDepth), end, kRadius}, {.young = 2e4});
  ASSERT_TRUE(truth.settled);
  EXPECT_NEAR(held_force(run) / truth.force.z(), 1, 0.02);
}

TEST(SelfContactSession, ADragLeavesTheSurfaceFreeOfCrossings) {
  const SessionResult run = Session(touching_scene(0.03), stack()).run();
  ASSERT_TRUE(run.self_contact.has_value());
  EXPECT_EQ(run.self_contact->crossings, 0);
  EXPECT_GT(run.self_contact->extremes.contacts, 20);
  EXPECT_GT(run.self_contact->extremes.nearest, 0);
  EXPECT_GT(run.self_contact->extremes.normal, held_force(run));  // the tool's force and the weight go through it
  EXPECT_EQ(run.missed_impacts, 0);
  for (const LocalFrame& f : run.frames) {
    ASSERT_TRUE(f.force.allFinite());
    EXPECT_LT(f.force.norm(), 5);
  }
}

TEST(SelfContactSession, ABodyThatCrossesItselfIsRefused) {
  const Mesh block = kuhn_block(6, 6, 2, kCell);
  const std::string said = message([&] {
    Session(touching_scene(), joined({block, placed(block, {0.0011, 0.0007, 0.9 * kThick})}));
  });
  EXPECT_EQ(said.rfind("global.self_contact: stack: the surface crosses or touches itself at the start in ", 0), 0u)
      << said;
}

TEST(SelfContactSession, OtherIntegratorsAreRefused) {
  Scene scene = touching_scene();
  scene.global.integrator = "quasistatic";
  EXPECT_EQ(message([&] { Session(scene, stack()); }),
            "global.integrator \"quasistatic\" steps through a body's contacts with itself; global.self_contact needs "
            "newton_euler (the default beside it)");
}

}  // namespace
}  // namespace kt
