// The haptic tick over long ways: memory, contact on closed smooth surfaces, random drags, broken input.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/allocations.hpp"
#include "tests/support/haptics_body.hpp"

namespace kt {
namespace {

const SoftBlock& block() {
  static const SoftBlock body;
  return body;
}

TEST(Tick, AllocatesNothing) {
  for (const ToolShape& tool : {kPointTool, kSphereTool}) {
    const Vec3 start(0.04, 0.025, 0.021 + tool.radius);
    Press press(block(), tool, "coulomb", {0.4, 0.3}, start);
    const auto allocations = allocations_during([&] {
      for (int i = 0; i < 10000; ++i) {  // presses, circles and lets go, again and again
        const double phase = 0.01 * i;
        press.go_to(start +
                    Vec3(0.01 * std::sin(phase), 0.007 * std::cos(phase), -0.001 - 0.0015 * std::sin(1.7 * phase)));
      }
    });
    EXPECT_EQ(allocations, 0);
  }
}

TEST(Tick, AllocatesNothingWithThePapersLaws) {
  const SoftBlock body{
      SoftBlockOptions{.young = 1000, .scheme = LocalScheme::symplectic_euler, .metric = Metric::identity}};
  for (const char* law : {"paper_slide", "paper_stick", "paper_stick_slip"}) {
    const Vec3 start(0.04, 0.025, 0.021);
    Press press(body, kPointTool, law, {0.5, 0.5}, start);
    const auto allocations = allocations_during([&] {
      press.move(start - Vec3(0, 0, 0.002), 100);
      press.move(start + Vec3(0.01, 0, -0.002), 400);
      press.move(start, 100);
    });
    EXPECT_EQ(allocations, 0) << law;
  }
}

TEST(Adopt, AllocatesNothing) {
  const Vec3 start(0.04, 0.025, 0.021);
  Press press(block(), kPointTool, "coulomb", {0.5, 0.5}, start);
  press.move(start - Vec3(0, 0, 0.002), 50);
  auto next = block().local_model(start);
  std::unique_ptr<PreparedLocalModel> old;
  EXPECT_EQ(allocations_during([&] { old = press.local().adopt(std::move(next)); }), 0);
}

TEST(Tick, NonFiniteToolGivesNoForceAndRecovers) {
  const Vec3 start(0.04, 0.025, 0.021);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    Press press(block(), kPointTool, "coulomb", {0.5, 0.5}, start);
    press.move(start - Vec3(0, 0, 0.002), 50);
    const LocalFrame frame = press.go_to(Vec3(bad, 0, 0));
    EXPECT_TRUE(frame.force.allFinite());
    press.local().step({start, start});
    const LocalFrame after = press.local().step({start, start - Vec3(0, 0, 0.002)});
    EXPECT_TRUE(after.force.allFinite());
    EXPECT_TRUE(press.local().model().state.q.allFinite());
  }
}

struct Around {
  const char* mesh;
  double layer;
  double ring, tube;  // [m] torus: the tool goes round the tube; sphere: ring 0
};

/// Slides a tool `depth` deep over the upper part of a body of revolution, along a slanted circle: over faces, edges
/// and vertices alike. Counts the ticks without contact.
int ticks_without_contact(const Around& shape, const ToolShape& tool, double mu, double depth) {
  const SoftBlock body{SoftBlockOptions{.mesh = shape.mesh, .layer = shape.layer, .clamped = 0.3}};
  const auto place = [&](double s, double gap) {
    // s in 0..1: from one side over the top to the other, and a little round the axis at the same time.
    const double tilt = 1.6 * (s - 0.5), turn = 0.7 * s;
    const double out = shape.tube + tool.radius + gap;
    const double r = shape.ring + out * std::sin(tilt);
    return Vec3(r * std::cos(turn), r * std::sin(turn), out * std::cos(tilt));
  };
  Press press(body, tool, "coulomb", {mu, mu}, place(0, 0.001));
  press.move(place(0, -depth), 60);
  int lost = 0;
  for (int i = 0; i <= 1500; ++i) {
    const LocalFrame frame = press.go_to(place(i / 1500.0, -depth));
    lost += frame.mode == ContactMode::free;
    EXPECT_TRUE(frame.force.allFinite());
    EXPECT_LE(frame.cone_ratio, mu * (1 + 1e-9) + 1e-12);
  }
  return lost;
}

TEST(ClosedSmoothSurface, KeepsContactAllTheWay) {
  const Around sphere{"sphere.off", 0.008, 0, 0.03}, torus{"torus.off", 0.005, 0.04, 0.015};
  for (const Around& shape : {sphere, torus})
    for (const ToolShape& tool : {kPointTool, kSphereTool})
      for (double mu : {0.0, 0.3, 1.0})
        EXPECT_EQ(ticks_without_contact(shape, tool, mu, 0.0015), 0)
            << shape.mesh << (tool.radius > 0 ? ", sphere" : ", point") << ", mu " << mu;
}

}  // namespace
}  // namespace kt
