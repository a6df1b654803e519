// A tool never jumps: neither over a gap in the poses nor with a pose that no hand can have.
#include "haptics/guard/followed_pose.hpp"

#include <gtest/gtest.h>

#include "haptics/guard/safety_chain.hpp"
#include "haptics/safety/passivity.hpp"

namespace kt {
namespace {

constexpr double kTick = 1e-3;  // [s]

Pose at(double z, double angle = 0) { return {Vec3(0, 0, z), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitX()))}; }

TEST(FollowedPose, AHandIsFollowedAsItIs) {
  FollowedPose followed(1);
  for (int i = 0; i < 2000; ++i) {  // 2.5 m/s and 50 rad/s at most
    const Pose device = at(0.05 * std::sin(0.05 * i), std::sin(0.05 * i));
    EXPECT_EQ(followed.follow(device, kTick), device) << i;
  }
  EXPECT_EQ(followed.jumps(), 0);
}

TEST(FollowedPose, PosesThatComeSeldomAreNoLeaps) {
  FollowedPose followed(1);
  for (int i = 0; i < 400; ++i) followed.follow(at(8e-3 * (i / 4)), kTick);  // 2 m/s, a new pose every 4 ms
  EXPECT_EQ(followed.jumps(), 0);
}

TEST(FollowedPose, ALeapIsFollowedSlowly) {
  FollowedPose followed(1);
  followed.follow(at(0), kTick);
  double before = 0;
  int ticks = 0;
  while (followed.follow(at(-0.017), kTick).x.z() > -0.017 && ticks < 1000) ++ticks;  // 17 m/s
  EXPECT_NEAR(ticks, 87, 2) << "20 ms at rest, 17 mm at 0.25 m/s";
  EXPECT_EQ(followed.jumps(), 1);
  EXPECT_FALSE(followed.has_jumped()) << "it has arrived";
  EXPECT_NEAR(followed.jumped().z(), -0.017, 1e-15);
  for (int i = 0; i < 50; ++i) {  // there and back
    const double z = followed.follow(at(i == 10 ? -0.1 : -0.017), kTick).x.z();
    EXPECT_TRUE(i == 0 || std::abs(z - before) <= FollowedPose::kFollows * kTick + 1e-12) << i;
    EXPECT_EQ(followed.is_on_the_way(), i == 10) << i;
    before = z;
  }
  EXPECT_NEAR(followed.jumped().z(), -0.017, 1e-15) << "there and back is nothing";
}

TEST(FollowedPose, ATurnLeapsNoMoreThanAPlace) {
  FollowedPose followed(1);
  followed.follow(at(0), kTick);
  double angle = 0;
  int ticks = 0;
  for (; angle < 1 - 1e-9 && ticks < 1000; ++ticks) {
    const double next = Eigen::AngleAxisd(followed.follow(at(0, 1), kTick).r).angle();
    EXPECT_LE(next - angle, FollowedPose::kTurns * kTick + 1e-9);
    angle = next;
  }
  EXPECT_NEAR(ticks, 420, 2) << "20 ms at rest, 1 rad at 2.5 rad/s";
}

TEST(FollowedPose, ALeapIsMeasuredAtTheDevice) {
  FollowedPose large(10);  // a device that moves a tool ten times as far
  large.follow(at(0), kTick);
  large.follow(at(-0.02), kTick);  // 2 m/s of the hand
  EXPECT_EQ(large.jumps(), 0);
  large.follow(at(-0.06), kTick);
  EXPECT_EQ(large.jumps(), 1);
}

/// A spring of 500 N/m, pressed 0.74 mm deep: 0.37 N. A pose 4.3 mm deeper, from one tick to the next, has 2.5 N.
TEST(SafetyChain, APoseThatCannotBeGivesNoForce) {
  for (const int lasts : {1, 500}) {  // ticks
    SafetyOptions o;
    o.device = {.max_force = 7.9, .yields = true, .is_live = true};
    o.most_damping = 20;
    o.coupling = 0;
    SafetyChain chain(o);
    double most = 0;
    for (int i = 0; i < 1500; ++i) {
      const Pose device = at(i >= 1000 && i < 1000 + lasts ? -0.005 : -0.74e-3);
      LocalFrame frame;
      frame.pose = chain.tool(device, kTick);
      frame.force.z() = frame.f_n = 500 * std::max(0.0, -frame.pose.x.z());
      frame.normal = Vec3::UnitZ();
      const double given = chain.make_safe(frame, device, {}, kTick).force.z();
      most = std::max(most, given);
      EXPECT_TRUE(i != 999 || std::abs(given - 0.37) < 1e-6) << given;
      EXPECT_TRUE(i != 1000 || chain.reason() == GateReason::jumped) << name_of(chain.reason());
      EXPECT_TRUE(i >= 1036 || given <= 0.3701) << i << ": the tool has not arrived";
    }
    EXPECT_LE(most, lasts > 1 ? 2.5 : 0.3701) << "who stays there gets what is there, slowly";
    EXPECT_GE(chain.counts().jumps, 1);
    EXPECT_GT(chain.counts().by_reason[static_cast<std::size_t>(GateReason::jumped)], 0);
    EXPECT_GE(chain.passivity()->least(), -1e-3) << "a leap is no work of the hand's";
  }
}

}  // namespace
}  // namespace kt
