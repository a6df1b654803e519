// Capsules and mesh tools in the haptic tick.
#include <gtest/gtest.h>

#include "tests/support/haptics_body.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

const Vec3 kOver(0.03, 0.026, 0.0301 + 0.004);

double top(const SoftBlock& body) { return bounds(body.model->mesh()).max.z(); }

/// Force after a press by `depth` over kOver.
LocalFrame pressed(const SoftBlock& body, const ToolShape& tool, double above, double depth) {
  const Vec3 start(kOver.x(), kOver.y(), top(body) + above + 1e-4);
  Press press(body, tool, "coulomb", {0.3, 0.3}, start);
  press.move(start - Vec3(0, 0, depth + 1e-4), 100);
  const LocalFrame frame = press.move(press.tool(), 100);
  EXPECT_LT(press.penetration(), 1e-6);
  return frame;
}

TEST(ToolShapes, AShortCapsuleIsASphere) {
  const SoftBlock body({.reducer = "condensed", .reach = 0.02});
  const LocalFrame sphere = pressed(body, kSphereTool, 0.004, 0.003);
  const LocalFrame capsule = pressed(body, make_capsule(0.004, 1e-9), 0.004, 0.003);
  EXPECT_NEAR(capsule.f_n, sphere.f_n, 1e-3 * sphere.f_n);
}

TEST(ToolShapes, AFineBallOfTrianglesIsNearlyASphere) {
  const SoftBlock body({.reducer = "condensed", .reach = 0.02});
  const LocalFrame sphere = pressed(body, kSphereTool, 0.004, 0.003);
  const LocalFrame ball = pressed(body, ball_tool(0.004, 8, 0.001), 0.004, 0.003);
  EXPECT_NEAR(ball.f_n, sphere.f_n, 0.1 * sphere.f_n);
}

TEST(ToolShapes, ALongCapsuleThatLiesMeetsMoreThanAnUprightOne) {
  const SoftBlock body({.reducer = "condensed", .reach = 0.02});
  const LocalFrame upright = pressed(body, make_capsule(0.003, 0.02), 0.013, 0.002);
  const LocalFrame frame = pressed(body, lying_capsule(0.003, 0.02), 0.003, 0.002);
  EXPECT_GT(frame.f_n, 1.5 * upright.f_n);
  EXPECT_GE(frame.contacts, 2);
}

/// A sphere that turns on the spot drags the surface along: friction along w x (from centre to contact), at the cone.
TEST(ToolShapes, ATurningSphereRubs) {
  const SoftBlock body({.reducer = "condensed", .reach = 0.02});
  const Vec3 start(kOver.x(), kOver.y(), top(body) + 0.0041);
  Press press(body, kSphereTool, "coulomb", {0.4, 0.4}, start);
  press.move(start - Vec3(0, 0, 0.0021), 100);
  LocalFrame frame;
  for (int i = 1; i <= 200; ++i) frame = press.go_to(press.tool(), Vec3(0, 0.02 * i, 0));  // 20 rad/s about y
  EXPECT_GT(frame.f_n, 0);
  EXPECT_NEAR(frame.f_t, 0.4 * frame.f_n, 0.02 * frame.f_n);
  // The lowest point of the ball goes to -x: the body holds it back, the force on the tool goes to +x.
  EXPECT_GT(frame.force.x(), 0.8 * frame.f_t);
}

class DraggedTool : public testing::TestWithParam<const char*> {};

TEST_P(DraggedTool, StaysOutOfTheBodyAndInTheCone) {
  const std::string name = GetParam();
  const ToolShape tool = name == "capsule" ? lying_capsule(0.003, 0.012) : box_tool({0.005, 0.004, 0.003}, 2, 0.001);
  const SoftBlock body({.reducer = "condensed", .reach = 0.02});
  const double above = name == "capsule" ? 0.003 : 0.004;
  const Vec3 start(0.02, 0.026, top(body) + above + 1e-4);
  Press press(body, tool, "coulomb", {0.5, 0.4}, start);
  int touched = 0, exhausted = 0, unsettled = 0;
  double deepest = 0;
  for (int i = 0; i < 500; ++i) {
    const double down = 0.002 * std::min(1.0, i / 100.0), along = i < 100 ? 0 : 5e-5 * (i - 100);
    const LocalFrame frame = press.go_to(start + Vec3(along, 0, -down - 1e-4), Vec3(0, 0, 1e-3 * i));
    ASSERT_TRUE(frame.force.allFinite());
    touched += frame.mode != ContactMode::free;
    exhausted += (frame.flags & kEventsExhausted) != 0;
    EXPECT_LE(frame.cone_ratio, 0.5 * (1 + 1e-6));
    deepest = std::max(deepest, press.penetration());
    unsettled += press.penetration() > 1e-6;
  }
  EXPECT_GT(touched, 480);
  EXPECT_EQ(exhausted, 0);
  // In ticks in which contacts come and go the iteration ends before they all agree: few, and by little of the depth.
  EXPECT_LE(unsettled, 50);
  EXPECT_LT(deepest, 0.01 * 0.002);
}

INSTANTIATE_TEST_SUITE_P(Shapes, DraggedTool, testing::Values("capsule", "box"),
                         [](const auto& p) { return std::string(p.param); });

}  // namespace
}  // namespace kt
