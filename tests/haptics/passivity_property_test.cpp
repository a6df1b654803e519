// Energy at the device: what the observer counts, and that the controller takes back what holding the force gave away.
#include <gtest/gtest.h>

#include "haptics/device/hand_loop.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/safety/passivity.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

/// A hand held to one place on a wall without damping of its own, and its true energy, tick by tick.
struct Wall {
  double returned = 0;  ///< most energy that the hand got beyond what it had put in [J]
  double one_tick = 0;  ///< most that any one tick gave it [J]
  double swing = 0;     ///< of the tool in the last quarter [m]
  int damped_ticks = 0;
};

/// @param counted  what the observer made of it [J]
Wall press(const HandLoop& loop, double most_damping, double push, double& counted) {
  DeviceOptions o;
  o.path = {{0, {0, 0, 0}}, {0.05, {0, 0, -push}}};
  o.h = loop.h;
  o.hand_mass = loop.mass;
  o.hand_stiffness = loop.hand_stiffness;
  o.hand_damping = loop.hand_damping;
  o.hand_delay = loop.delay;
  o.encoder_step = 0;
  const auto hand = make_device("hand", o);
  PassivityControl passivity({most_damping, loop.h, loop.delay});
  Wall out;
  constexpr int kTicks = 4000;
  double put_in = 0, low = 1e9, high = -1e9, before = hand->pose(0).x.z();
  std::vector<double> acting(static_cast<std::size_t>(std::lround(loop.delay / loop.h)) + 1, 0.0);
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 x = hand->pose(0).x;
    const double work = acting.back() * (x.z() - before);  // on the hand, in the tick that just ended
    before = x.z();
    put_in -= work;
    out.one_tick = std::max(out.one_tick, work);
    out.returned = std::max(out.returned, -put_in);
    const Vec3 force = passivity.tick(x, Vec3(0, 0, -loop.wall_stiffness * x.z()));
    acting.insert(acting.begin(), force.z());
    acting.pop_back();
    hand->write({.force = force}, loop.h);
    if (i < 3 * kTicks / 4) continue;
    low = std::min(low, x.z());
    high = std::max(high, x.z());
  }
  out.swing = high - low;
  out.damped_ticks = passivity.damped_ticks();
  counted = std::max(0.0, -passivity.least());
  return out;
}

HandLoop loop_of(double damping, double delay) {
  HandLoop out;
  out.hand_damping = damping;
  out.delay = delay;
  return out;
}

TEST(Passivity, TheHandNeverGetsMoreBackThanItPutInAndOneTickGives) {
  Sample s{std::mt19937_64(5)};
  for (int i = 0; i < 40; ++i) {
    HandLoop loop = loop_of(s.uniform(0.1, 2), 1e-3 * static_cast<double>(s.random() % 3));
    loop.wall_stiffness = s.uniform(1.2, 3) * stiffest_stable_wall(loop);
    double counted = 0;
    const Wall free = press(loop, 0, 1e-3, counted), controlled = press(loop, 20, 1e-3, counted);
    EXPECT_LE(controlled.returned, controlled.one_tick) << loop.wall_stiffness << ' ' << loop.hand_damping;
    EXPECT_GT(free.returned, 100 * controlled.returned) << "without control energy grows without bound";
    EXPECT_LT(controlled.swing, 1e-4);
  }
}

TEST(Passivity, TheObserverCountsTheEnergyThatThereIs) {
  for (double delay : {0.0, 1e-3, 3e-3}) {
    HandLoop loop = loop_of(1, delay);
    loop.wall_stiffness = 1.1 * stiffest_stable_wall(loop);
    double counted = 0;
    const Wall wall = press(loop, 0, 1e-3, counted);
    EXPECT_GT(wall.returned, 0);
    EXPECT_NEAR(counted, wall.returned, 1e-9 * wall.returned);
  }
}

TEST(Passivity, CountsWhatTheDeviceCanGive) {
  // Pressed in to 20 N and let out again, 2 N at most: what is cut off on the way in is cut off on the way out.
  constexpr double kStiffness = 1e4, kLimit = 2, kStep = 1e-6;
  PassivityControl control({.most_damping = 20, .h = 1e-3, .delay = 0, .max_force = kLimit});
  double put_in = 0, before = 0, force = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double z = -kStep * (i <= 2000 ? i : 4000 - i);
    put_in -= force * (z - before);
    before = z;
    force = control.tick({0, 0, z}, {0, 0, -kStiffness * z}).z();
    ASSERT_LE(force, kLimit);
    EXPECT_NEAR(control.taken(), put_in, 1e-15) << "by the force that was written";
    if (i == 100) {
      EXPECT_FALSE(control.limited());
    } else if (i == 2000) {
      EXPECT_TRUE(control.limited());
      EXPECT_NEAR(control.taken(), kLimit * 2e-3 - 0.5 * kLimit * kLimit / kStiffness, 1e-5);
    }
  }
  EXPECT_LT(control.most_debt(), 1e-5) << "a spring that is cut gives back no more than it took";
}

TEST(Passivity, LeavesAloneWhatGivesNoEnergy) {
  PassivityControl control({.most_damping = 20, .h = 1e-3, .delay = 0});
  // A damper takes energy in every tick.
  for (int i = 0; i < 100; ++i) {
    const Vec3 force(0, 0, -1);
    EXPECT_EQ(control.tick(Vec3(0, 0, 1e-4 * i), force), force);
  }
  EXPECT_EQ(control.damped_ticks(), 0);
  EXPECT_GT(control.taken(), 0);
}

}  // namespace
}  // namespace kt
