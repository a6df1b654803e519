#include "haptics/device/moved_target.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace kt {
namespace {

TEST(MovedTarget, IsNeverFasterThanItMayBe) {
  MovedTarget target(Vec3::Zero(), 0.25);
  target.move({0.1, 0, 0});  // a jump
  Vec3 before = Vec3::Zero();
  for (int i = 0; i < 1000; ++i) {
    const Vec3 now = target.step(1e-3);
    EXPECT_LE((now - before).norm(), 0.25e-3 * (1 + 1e-12));
    before = now;
  }
  EXPECT_NEAR((before - Vec3(0.1, 0, 0)).norm(), 0, 1e-6);
}

// A tick that is longer than a sample arrives, and goes no further.
TEST(MovedTarget, ALongStepDoesNotOvershoot) {
  MovedTarget target(Vec3::Zero(), 1e9);
  target.move({0.1, 0, 0});
  EXPECT_NEAR((target.step(0.05) - Vec3(0.1, 0, 0)).norm(), 0, 1e-15);
}

TEST(MovedTarget, WhatIsNotFiniteIsLeftOut) {
  MovedTarget target({1, 2, 3}, 0.25);
  target.move({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  target.move({0, std::numeric_limits<double>::infinity(), 0});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(target.step(1e-3), Vec3(1, 2, 3));
}

// Places are written whole: all three numbers of one, whatever the other thread does.
TEST(MovedTarget, NoPlaceIsReadInHalves) {
  MovedTarget target(Vec3::Zero(), 1e9);
  const std::jthread writer([&](const std::stop_token& stop) {
    for (double v = 0; !stop.stop_requested(); v = v < 1e6 ? v + 1 : 0) target.move({v, v, v});
  });
  for (int i = 0; i < 200000; ++i) {
    const Vec3 x = target.step(1);  // long enough to arrive
    ASSERT_NEAR(x[0], x[1], 1e-6);
    ASSERT_NEAR(x[0], x[2], 1e-6);
  }
}

}  // namespace
}  // namespace kt
