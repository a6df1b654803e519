// A tool that gets beyond the patch before the next local model is there goes on touching the body; where it does not,
// the run says so.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/body/mesh.hpp"
#include "haptics/findings/run_findings.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// Most local models are lost on their way: the tool goes on over the ones that are there.
Scene runs_off(const std::string& shape) {
  Scene scene = small_scene(shape);
  scene.duration = 0.7;
  scene.link.loss = 0.97;
  scene.seed = 3;
  scene.global.early_refresh = false;
  if (shape == "capsule") {
    scene.tool.radius = 0.003;
    scene.tool.length = 0.008;
  }
  return scene;
}

int edge_ticks(const SessionResult& run) {
  return static_cast<int>(
      std::ranges::count_if(run.tools[0].frames, [](const LocalFrame& f) { return (f.flags & kLeftPatch) != 0; }));
}

class BeyondThePatch : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Tools, BeyondThePatch, testing::Values("sphere", "point", "capsule"),
                         [](const auto& shape) { return std::string(shape.param); });

TEST_P(BeyondThePatch, ContactGoesOn) {
  for (const char* surface : {"flat", "loop"}) {
    if (surface != std::string("flat") && GetParam() != std::string("sphere")) continue;
    SCOPED_TRACE(surface);
    Scene scene = runs_off(GetParam());
    scene.contact.surface = surface;
    const SessionResult run = Session(scene).run();
    EXPECT_GT(edge_ticks(run), 100) << "it never got there";
    EXPECT_EQ(run.tools[0].lost.free_ticks_inside, 0);
    EXPECT_EQ(run.tools[0].missed_impacts, 0);
    EXPECT_FALSE(contact_was_lost(scene, run));
    const auto pressed = std::span<const LocalFrame>(run.tools[0].frames).subspan(150);
    double least = 1e9, most = 0;
    for (const LocalFrame& f : pressed) {
      least = std::min(least, f.f_n);
      most = std::max(most, f.f_n);
    }
    EXPECT_GT(least, 0);
    EXPECT_EQ(measure_forces(pressed, 0.15, 1e-3).lost_contacts, 0);
    EXPECT_EQ(run.tools[0].penetration.size(), run.tools[0].frames.size());
  }
}

TEST(LostContact, OfAThreadedRunIsCheckedToo) {
  Scene scene = small_scene();
  scene.link.type = "thread";
  const SessionResult live = Session(scene).run();
  ASSERT_EQ(live.tools[0].penetration.size(), live.tools[0].frames.size());
  EXPECT_EQ(live.tools[0].lost.unchecked_ticks, 0);
  EXPECT_EQ(live.refresh.cpu_ms.size(), live.refreshes.size());
  SessionOptions replay = replay_of(live);
  const SessionResult again = Session(scene).run(replay);
  ASSERT_EQ(again.hash, live.hash);
  EXPECT_EQ(again.tools[0].missed_impacts, live.tools[0].missed_impacts);
  EXPECT_EQ(again.tools[0].lost.free_ticks_inside, live.tools[0].lost.free_ticks_inside);
  EXPECT_TRUE(std::ranges::equal(again.tools[0].penetration, live.tools[0].penetration))
      << "the same body, tick by tick";
}

/// Above the body in one tick, below it in the next, over a corner of a triangle or anywhere.
TEST(LostContact, OfAToolThatLeapsThroughTheBodyIsReported) {
  for (const char* shape : {"sphere", "point"}) {
    Scene scene = small_scene(shape);
    scene.duration = 0.1;
    const double above = 0.2, below = -0.2;
    scene.tool.path.press_drag.reset();
    scene.tool.path.waypoints = {{0, {0.03, 0.026, above}},
                                 {0.05, {0.03, 0.026, above}},
                                 {0.0505, {0.03, 0.026, below}},
                                 {0.1, {0.03, 0.026, below}}};
    Session session(scene);
    const SessionResult run = session.run();
    EXPECT_GT(run.tools[0].missed_impacts, 0) << shape;
    EXPECT_TRUE(contact_was_lost(scene, run));
    const std::vector<Finding> found = all_findings(session, run);
    EXPECT_TRUE(has_failed(found));
    EXPECT_TRUE(std::ranges::any_of(lines(found), [](const std::string& w) {
      return w.find("most of all in tick 50 (t = 0.051 s) with 400 m/s, 0.4 m in one tick") != std::string::npos;
    }));
  }
}

/// What comes after the end, and a row that is off, make no patch larger.
TEST(Reach, FollowsTheMeasuredSpeedAndIsBounded) {
  const auto with = [](std::vector<Waypoint> more) {
    Scene scene = small_scene();
    scene.tool.path.press_drag.reset();
    scene.tool.path.waypoints = {{0, {0.03, 0.026, 0.05}}, {0.3, {0.033, 0.026, 0.05}}};
    scene.tool.path.waypoints->insert(scene.tool.path.waypoints->end(), more.begin(), more.end());
    return Session(scene).run();
  };
  const SessionResult slow = with({}), lifts_later = with({{0.301, {0.033, 0.026, 5.0}}});
  EXPECT_GT(lifts_later.tools[0].max_speed, 1000);
  EXPECT_LE(lifts_later.last_patch_vertices, slow.last_patch_vertices + 30);
  Scene glitch = small_scene();
  glitch.tool.path.press_drag.reset();
  glitch.tool.path.waypoints = {{0, {0.03, 0.026, 0.05}},
                                {0.1, {0.03, 0.026, 0.05}},
                                {0.101, {0.03, 0.026, 3.0}},
                                {0.102, {0.03, 0.026, 0.05}},
                                {0.3, {0.03, 0.026, 0.05}}};
  Session session(glitch);
  const SessionResult run = session.run();
  EXPECT_LE(run.last_patch_vertices, slow.last_patch_vertices + 30);
  EXPECT_TRUE(std::ranges::any_of(lines(all_findings(session, run)), [](const std::string& w) {
    return w.find("too fast in 2 of 300 ticks, most of all in tick 10") != std::string::npos;
  }));
}

// On cells that are small beside the tool a patch around all of it, however little it touches, has several times the
// coordinates of one around the contact, and the same force.
TEST(Reach, FollowsTheContact) {
  Scene scene = small_scene();
  scene.object.fixed.below = FixedBelow{"z", 1e-6};
  scene.tool.radius = 0.008;
  scene.tool.path.press_drag = PressDrag{.at = std::array{0.03, 0.03}, .depth = 0.001, .press_time = 0.1, .speed = 0};
  const Mesh block = kuhn_block(24, 24, 6, 0.0025);
  const SessionResult pressed = Session(scene, block).run();
  scene.tool.path.press_drag.reset();
  const double top = 6 * 0.0025 + 0.008;
  scene.tool.path.waypoints = {{0, {0.03, 0.03, top + 1e-4}}, {0.3, {0.03, 0.03, top + 1e-4}}};
  const SessionResult above = Session(scene, block).run();
  EXPECT_GT(pressed.tools[0].frames.back().f_n, 0.01);
  EXPECT_EQ(edge_ticks(pressed), 0);
  EXPECT_LT(pressed.last_patch_vertices, 0.7 * above.last_patch_vertices);
}

}  // namespace
}  // namespace kt
