// The set-up of "auto", seconds of CPU time, is kept with the body: who begins in the same way again has the same bits
// without it, who begins in another way has his own.
#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/halves/body_side.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

/// 28 x 28 x 17 mm, 847 nodes: most of them follow others.
Mesh fine_block() { return kuhn_block(10, 10, 6, 2.8e-3); }

Scene auto_scene() {
  Scene scene = small_scene();
  scene.object.mesh = std::string("-");
  scene.object.model.type = "fem";
  scene.local.reducer = "auto";
  scene.duration = 0.25;
  scene.tool.path.press_drag = PressDrag{.at = std::array<double, 2>{0.013, 0.015},
                                         .depth = 0.0015,
                                         .press_time = 0.1,
                                         .direction = {1, 0.2, 0},
                                         .speed = 0.05};
  return scene;
}

double set_up_ms(const SessionResult& run) { return run.refresh.cpu_ms.front(); }

TEST(KeptSetUp, GivesTheSecondRunTheBitsOfTheFirstSooner) {
  Session session(auto_scene(), fine_block());
  const SessionResult first = session.run(), second = session.run();
  const SessionResult fresh = Session(auto_scene(), fine_block()).run();
  EXPECT_EQ(first.hash, fresh.hash);
  EXPECT_EQ(second.hash, fresh.hash);
  EXPECT_EQ(second.refreshes, first.refreshes);
  EXPECT_EQ(second.reducer_changes, first.reducer_changes);
  EXPECT_EQ(second.reducer_reason, first.reducer_reason);
  EXPECT_EQ(second.certified_error, first.certified_error);
  EXPECT_EQ(second.expected_force_error, first.expected_force_error);
  ASSERT_EQ(second.reducer_candidates.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(second.reducer_candidates[i].name, first.reducer_candidates[i].name);
    EXPECT_EQ(second.reducer_candidates[i].force_error, first.reducer_candidates[i].force_error);
  }
  std::printf("set-up: first %.0f ms of CPU time, second %.0f ms, of another body %.0f ms\n", set_up_ms(first),
              set_up_ms(second), set_up_ms(fresh));
  EXPECT_LT(set_up_ms(second), 0.5 * std::min(set_up_ms(first), set_up_ms(fresh)));
}

TouchOptions options_with(double tolerance) {
  TouchOptions out;
  out.tools[0].shape = {ToolShape::Kind::sphere, 0.004};
  out.local.reducer = "auto";
  out.local.tolerance = tolerance;
  out.collision.backend = "brute_force";
  return out;
}

struct Pressed {
  std::string reducer;
  std::vector<Vec3> force;
};

/// From above for 0.15 s, with a stiffness that is set before where it is not 0.
Pressed press(Touch& touch, const Vec3& at, double young) {
  if (young > 0) touch.set("object.model.young", young);
  touch.place(Pose{at});
  Pressed out;
  for (int i = 1; i <= 150; ++i) {
    out.force.push_back(touch.tick(Pose{at - Vec3(0, 0, 2.5e-3 * i / 150)}).force);
    if (i == 1) out.reducer = touch.status().reducer;
  }
  EXPECT_GT(out.force.back().norm(), 1e-4);
  return out;
}

Body make_block() {
  BodyOptions options;
  options.object.model.type = "fem";
  options.backend = "brute_force";
  return Body(kuhn_block(6, 6, 4, 4e-3), options);
}

/// All on one body, against each on a body of its own.
TEST(KeptSetUp, IsNotThatOfAnotherToleranceWeightOrPlace) {
  const Body one = make_block();
  const Vec3 middle(0.0121, 0.0123, 0.0205), aside(0.005, 0.0062, 0.0205);
  struct Way {
    double tolerance;
    Vec3 at;
    double young;
  };
  std::vector<std::string> reducers;
  for (const Way& way : {Way{1e-3, middle, 0}, {0.9, middle, 0}, {0.9, aside, 0}, {0.9, aside, 5e4}, {0.9, aside, 0}}) {
    Touch shared(one, options_with(way.tolerance));
    const Body other = make_block();
    Touch own(other, options_with(way.tolerance));
    const Pressed mine = press(shared, way.at, way.young), expected = press(own, way.at, way.young);
    EXPECT_EQ(mine.reducer, expected.reducer);
    EXPECT_EQ(mine.force, expected.force) << way.tolerance << ' ' << way.at.transpose() << ' ' << way.young;
    reducers.push_back(mine.reducer);
  }
  EXPECT_NE(reducers[0], reducers[1]) << "it would not tell";
}

TEST(KeptSetUp, ServesAResetWithTheSettingsAsTheyWereSet) {
  const Body body = make_block();
  Touch touch(body, options_with(0.02));
  const Vec3 at(0.0121, 0.0123, 0.0205);
  const Pressed first = press(touch, at, 4e4);
  touch.reset();
  EXPECT_EQ(press(touch, at, 0).force, first.force);
}

}  // namespace
}  // namespace kt
