// Bodies that touch one another, from the scene to the force on the hand.
#include <gtest/gtest.h>

#include "bench/pressed_bodies.hpp"
#include "haptics/findings/run_findings.hpp"
#include "lab/study/press.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

constexpr int kCells = 4;
constexpr double kCell = 0.005, kThick = 2 * kCell, kGap = 2e-4;  // [m]
constexpr double kDepth = 0.003, kRadius = 0.01;

Mesh stack() {
  const Mesh block = kuhn_block(kCells, kCells, 2, kCell);
  return joined({block, placed(block, {0, 0, kThick + kGap})});
}

/// A sphere pressed onto the middle, then held, or dragged at `speed`.
Scene press_scene(double speed = 0) {
  Scene scene;
  scene.title = "test";
  scene.local.refine = "off";  // forces are compared with those of the same cells
  scene.duration = 0.2;
  scene.object.mesh = "stack";
  scene.object.gravity = {0, 0, -9.81};
  scene.object.fixed.below->fraction = 0.01;
  scene.object.model.type = "fem";
  scene.object.model.young = 2e4;
  scene.tool.radius = kRadius;
  scene.tool.path.press_drag =
      PressDrag{.at = std::array<double, 2>{0.0095, 0.0105}, .depth = kDepth, .press_time = 0.1, .speed = speed};
  scene.contact.mu_static = scene.contact.mu_kinetic = 0.3;
  scene.collision.backend = "brute_force";
  scene.global.integrator = "newton_euler";
  scene.local.reducer = "condensed";
  return scene;
}

Scene touching_scene(double speed = 0) {
  Scene scene = press_scene(speed);
  scene.global.self_contact.emplace().mu = 0.5;
  return scene;
}

/// Mean normal force while the tool is held [N].
double held_force(const SessionResult& run) {
  double sum = 0;
  for (std::size_t i = 150; i < 200; ++i) sum += run.tools[0].frames[i].f_n / 50;
  return sum;
}

/// The force that the scene shows, and the one of the whole nonlinear body in equilibrium under the sphere [N].
struct Forces {
  double shown = 0, equilibrium = 0;
};

Forces press_both(const Scene& scene, const Mesh& body) {
  Session session(scene, body);
  const SessionResult run = session.run();
  const Vec3 end = run.tools[0].frames.back().pose.x;
  const PressSite site{end + Vec3(0, 0, kDepth), end, kRadius};
  if (!scene.global.self_contact)
    return {held_force(run), press(session.model(), session.start(), site, {.young = 2e4}).force.z()};
  SelfContact contact(session.model(), {.mu = 0.5});
  const TouchingModel touching(session.model(), contact, session.start(), 1);
  return {held_force(run), press(touching, session.start(), site, {.young = 2e4}).force.z()};
}

TEST(SelfContactSession, AStackResistsLikeTheBlockThatItWouldBeInOnePiece) {
  const Forces stacked = press_both(touching_scene(), stack());
  const Forces whole = press_both(press_scene(), kuhn_block(kCells, kCells, 4, kCell));
  const Forces upper = press_both(press_scene(), kuhn_block(kCells, kCells, 2, kCell));
  EXPECT_NEAR(stacked.shown / whole.shown, 1, 0.05);
  EXPECT_GT(upper.shown / whole.shown, 1.2);  // alone on the table it resists more: springs in a row are softer
  // Contact at some points is stiffer than pressure over the surface, by as much for all three.
  EXPECT_NEAR(stacked.shown / stacked.equilibrium, whole.shown / whole.equilibrium, 0.02);
}

TEST(SelfContactSession, ADragLeavesTheSurfaceFreeOfCrossings) {
  const SessionResult run = Session(touching_scene(0.03), stack()).run();
  ASSERT_TRUE(run.self_contact.has_value());
  EXPECT_EQ(run.self_contact->crossings, 0);
  EXPECT_GT(run.self_contact->extremes.contacts, 20);
  EXPECT_GT(run.self_contact->extremes.nearest, 0);
  EXPECT_GT(run.self_contact->extremes.normal, held_force(run));  // the tool's force and the weight go through it
  EXPECT_EQ(run.tools[0].missed_impacts, 0);
  for (const LocalFrame& f : run.tools[0].frames) {
    ASSERT_TRUE(f.force.allFinite());
    EXPECT_LT(f.force.norm(), 5);
  }
}

/// The upper block, a little aside, is pushed into the lower one, and the run says so; with self-contact it is not.
TEST(SelfContactSession, WithoutItABodyThatPassesThroughItselfIsTold) {
  const Mesh block = kuhn_block(kCells, kCells, 2, kCell);
  const Mesh aside = joined({block, placed(block, {0.0011, 0.0007, kThick + kGap})});
  const auto told = [&](Scene scene) {
    scene.object.gravity.setZero();
    Session session(scene, aside);
    const SessionResult run = session.run();
    std::vector<Finding> found = all_findings(session, run);
    std::erase_if(found, [](const Finding& f) { return f.what.find("passes through itself") == std::string::npos; });
    return found;
  };
  const std::vector<Finding> through = told(press_scene());
  ASSERT_EQ(through.size(), 1u);
  ASSERT_FALSE(through[0].cures.empty());
  EXPECT_EQ(through[0].cures[0].key, "global.self_contact");
  EXPECT_FALSE(is_trustworthy(through));
  EXPECT_TRUE(told(touching_scene()).empty());
}

TEST(SelfContactSession, ABodyThatCrossesItselfIsRefused) {
  const Mesh block = kuhn_block(kCells, kCells, 2, kCell);
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
