#include "haptics/tick/push_force.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kt {
namespace {

const Vec3 kUp = Vec3::UnitZ();

TEST(PushForce, LetsEverythingPassBeforeAPushAndAfterIt) {
  PushForce push;
  EXPECT_EQ(push.apply(1e5 * kUp, true, false), Vec3(1e5 * kUp));
  push.begin();
  EXPECT_EQ(push.apply(0.05 * kUp, true, true), Vec3(0.05 * kUp));
  EXPECT_EQ(push.apply(0.06 * kUp, true, false), Vec3(0.06 * kUp));  // the push has ended and the force has caught up
  EXPECT_FALSE(push.is_on());
  EXPECT_EQ(push.apply(1e5 * kUp, true, false), Vec3(1e5 * kUp));
}

TEST(PushForce, OfASmoothPushPassesToTheBit) {
  PushForce push;
  push.begin();
  for (int i = 0; i <= 60; ++i) {
    const double share = i / 60.0;
    const Vec3 force = 6 * share * share * (3 - 2 * share) * Vec3(0.3, 0.2, 0.9);
    EXPECT_EQ(push.apply(force, true, i < 60), force) << i;
  }
}

TEST(PushForce, BeginsWithTheFirstTouchAndLimitsEachStepUntilItHasCaughtUp) {
  PushForce push;
  push.begin();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(push.apply(Vec3::Zero(), false, true), Vec3::Zero());
  double last = 0;
  int ticks = 0;
  for (; ticks < 1000 && push.is_on(); ++ticks) {
    const double now = push.apply(5000 * kUp, true, ticks < 10).norm();
    EXPECT_LE(now - last, 0.1 + 0.05 * last + 1e-9);
    EXPECT_GT(now, last);
    last = now;
  }
  EXPECT_EQ(last, 5000);
  EXPECT_NEAR(ticks, std::log(1 + 0.05 * 5000 / 0.1) / std::log(1.05), 2);  // geometric growth
}

/// Whatever the rate, the force grows as fast: by 5 % in a millisecond, from 0.1 N on.
TEST(PushForce, GrowsByTimeAndNotByTicks) {
  const auto time_to = [](double h) {
    PushForce push(h);
    push.begin();
    int ticks = 0;
    while (push.apply(1000 * kUp, true, true).norm() < 1000) ++ticks;
    return ticks * h;
  };
  const double exact = std::log(1 + 0.05 * 1000 / 0.1) / 0.05 * 1e-3;  // of f' = (0.1 N + 0.05 f) / ms
  EXPECT_NEAR(time_to(1e-4), exact, 0.005 * exact);
  EXPECT_NEAR(time_to(1.0 / 8000), exact, 0.01 * exact);
  EXPECT_NEAR(time_to(1e-3), exact, 0.03 * exact);
}

TEST(PushForce, FallsByStepsTooAndSurvivesASecondBegin) {
  PushForce push;
  push.begin();
  for (int i = 0; i < 20; ++i) push.apply(10 * kUp, true, true);
  const double high = push.apply(10 * kUp, true, true).norm();
  EXPECT_GT(high, 2);
  push.begin();  // found inside again
  EXPECT_NEAR(push.apply(Vec3::Zero(), false, true).norm(), high - 0.1 - 0.05 * high, 1e-12);
}

TEST(PushForce, WithoutATouchEndsWithThePush) {
  PushForce push;
  push.begin();
  push.apply(Vec3::Zero(), false, false);
  EXPECT_FALSE(push.is_on());
}

}  // namespace
}  // namespace kt
