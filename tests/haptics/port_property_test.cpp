// At the device's port: late ticks, forces that later stages cut, axes by themselves, velocity, turning, delay.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "apps/console/allocation_counter.hpp"
#include "core/base/types.hpp"
#include "haptics/safety/measured_delay.hpp"
#include "haptics/safety/passivity.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

/// Work of forces that were written at some times and act `delay` later, on a path of straight pieces between the same
/// times: piece by piece, with no look at how DelayedForces sums.
double true_work(const std::vector<double>& t, const std::vector<Vec3>& x, const std::vector<Vec3>& f, double delay) {
  double out = 0;
  for (std::size_t i = 1; i < t.size(); ++i)
    for (std::size_t j = 0; j < t.size(); ++j) {
      const double from = std::max(t[i - 1], t[j] + delay);
      const double to = std::min(t[i], j + 1 < t.size() ? t[j + 1] + delay : 1e9);
      if (to > from) out += f[j].dot(x[i] - x[i - 1]) * (to - from) / (t[i] - t[i - 1]);
    }
  return out;
}

TEST(Port, CountsTheWorkOfForcesThatComeLateInTicksThatComeLate) {
  Sample s{std::mt19937_64(3)};
  for (int run = 0; run < 30; ++run) {
    const double delay = s.uniform(0, 4e-3);
    PassivityControl control({.most_damping = 10, .delay = 0, .most_delay = 5e-3});
    control.set_delay(delay);
    std::vector<double> t{0};
    std::vector<Vec3> x, f;
    for (int i = 0; i < 200; ++i) {
      const double dt = run % 2 == 0 || i % 3 == 0 ? 1e-3 : s.uniform(0.6e-3, 2.5e-3);
      if (i > 0) t.push_back(t.back() + dt);
      x.push_back(1e-4 * s.cube());
      Vec3 given = control.tick(x.back(), s.cube(), dt);
      if (i % 5 == 0) {  // a later stage cuts it
        given *= s.uniform(0, 1);
        control.written(given);
      }
      f.push_back(given);
      ASSERT_NEAR(control.taken(), -true_work(t, x, f, delay), 1e-12) << "tick " << i << ", delay " << delay;
    }
  }
}

TEST(Port, ADelayThatChangesIsReckonedWithAndNeedsNoRoom) {
  PassivityControl control({.most_damping = 10, .delay = 0, .most_delay = 3e-3});
  const long long before = thread_allocations();
  for (int i = 0; i < 100; ++i) {
    if (i % 10 == 0) control.set_delay(1e-3 * (i / 10 % 5));
    control.written(0.5 * control.tick({0, 0, 1e-4 * (i % 7)}, {0, 0, 1}, 1e-3));
  }
  EXPECT_EQ(thread_allocations(), before);
  control.set_delay(1);
  EXPECT_EQ(control.delay(), 3e-3) << "cut to what there is room for";
  // A force of 1 N for ever, moved along with it by 1 mm a tick: whatever the delay, 1 mJ a tick.
  PassivityControl even({.delay = 2e-3, .most_delay = 5e-3});
  for (int i = 0; i < 20; ++i) even.tick(Vec3::Zero(), {0, 0, 1});
  const double taken = even.taken();
  even.tick({0, 0, 1e-3}, {0, 0, 1});
  even.set_delay(4.5e-3);
  even.tick({0, 0, 2e-3}, {0, 0, 1});
  EXPECT_NEAR(even.taken() - taken, -2e-3, 1e-12);
}

TEST(Port, AForceThatWasCutWasNeverFelt) {
  // In and out of a spring whose force a gate holds at zero: nothing was given, nothing is owed, nothing is damped.
  PassivityControl shut({.most_damping = 20});
  for (int i = 0; i < 200; ++i) {
    const double z = -1e-4 * (i < 100 ? i : 200 - i);
    shut.tick({0, 0, z}, {0, 0, -1000 * z});
    shut.written(Vec3::Zero());
  }
  EXPECT_EQ(shut.taken(), 0);
  EXPECT_LT(shut.debt(), 1e-15);
  EXPECT_LT(shut.most_debt(), 1e-15);
  // Half of it is a spring of half the stiffness: counted as that one by itself is.
  PassivityControl half({}), soft({});
  for (int i = 0; i < 200; ++i) {
    const double z = -1e-4 * (i < 100 ? i : 200 - i);
    half.written(0.5 * half.tick({0, 0, z}, {0, 0, -1000 * z}));
    soft.tick({0, 0, z}, {0, 0, -500 * z});
  }
  EXPECT_NEAR(half.taken(), soft.taken(), 1e-15);
  EXPECT_NEAR(half.debt(), soft.debt(), 1e-15);
  EXPECT_GT(soft.debt(), 1e-4) << "and its hold gave something";
}

TEST(Port, TheDamperIsCutAsTheRestIs) {
  // A gate half open, over a spring and the damper that pays for its hold: the spring that is felt is half of it.
  PassivityControl control({.most_damping = 20});
  Vec3 before = Vec3::Zero(), given = Vec3::Zero(), spring = Vec3::Zero();
  double by_hold = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 x(0, 0, -2e-3 + 1e-4 * (i % 20 < 10 ? i % 20 : 20 - i % 20)), wanted(0, 0, -2000 * x.z());
    const Vec3 way = i > 0 ? Vec3(x - before) : Vec3(Vec3::Zero()), half = 0.5 * wanted;
    by_hold += given.dot(way) - 0.5 * (spring + half).dot(way);
    given = 0.5 * control.tick(x, wanted);
    control.written(given);
    EXPECT_NEAR(control.given_by_hold(), by_hold, 1e-15) << i;
    before = x;
    spring = half;
  }
  EXPECT_GT(control.damped_ticks(), 100);
}

TEST(Port, OneAxisDoesNotPayForTheOther) {
  // Along y a resistance that weakens with the way, whose hold takes five times what that of the spring along z gives.
  PassivityControl apart({.axes_apart = true}), one({});
  PassivityControl controlled({.most_damping = 20, .axes_apart = true}), blind({.most_damping = 20});
  for (int i = 0; i < 400; ++i) {
    const double z = -2e-3 + 1e-4 * (i % 20 < 10 ? i % 20 : 20 - i % 20), y = 1e-4 * i;
    const Vec3 x(0, y, z), f(0, -200 + 0.5 * i, -1000 * z);
    const PortKnowledge known{.normal = Vec3(0, 0, 1)};
    apart.tick(x, f, 1e-3, known);
    one.tick(x, f);
    const Vec3 left = controlled.tick(x, f, 1e-3, known);
    EXPECT_EQ(left.y(), f.y()) << "it is the normal's debt alone that is paid, along the normal";
    EXPECT_EQ(blind.tick(x, f), f);
  }
  // By hand: z gives 1/2 K dz^2 a tick.
  EXPECT_NEAR(apart.debt(0), 399 * 0.5 * 1000 * 1e-8, 1e-9);
  EXPECT_EQ(apart.debt(1), 0) << "what an axis has taken is not kept for later";
  EXPECT_EQ(one.debt(), 0);
  EXPECT_GT(controlled.damped_ticks(), 300);
  EXPECT_NEAR(apart.given_by_hold(), one.given_by_hold(), 1e-15);
}

TEST(Port, ApartTheyAddUpToTheSameWork) {
  Sample s{std::mt19937_64(4)};
  PassivityControl apart({.axes_apart = true}), one({});
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = 1e-4 * s.cube(), f = s.cube();
    apart.tick(x, f, 1e-3, {.normal = s.cube().normalized()});
    one.tick(x, f);
    EXPECT_NEAR(apart.taken(), one.taken(), 1e-13);
    EXPECT_NEAR(apart.given_by_hold(), one.given_by_hold(), 1e-13);
  }
}

TEST(Port, TheDamperTakesTheDevicesOwnVelocity) {
  // An encoder that stands still in this tick, a device that knows that it moves: the debt is paid all the same.
  PassivityControl control({.most_damping = 20});
  control.tick({0, 0, -1e-3}, {0, 0, 1});
  control.tick({0, 0, -0.9e-3}, {0, 0, 0.9});
  const Vec3 still = control.tick({0, 0, -0.9e-3}, {0, 0, 0.8}, 1e-3, {.velocity = Vec3(0, 0, 0.1)});
  EXPECT_LT(still.z(), 0.8);
  PassivityControl blind({.most_damping = 20});
  blind.tick({0, 0, -1e-3}, {0, 0, 1});
  blind.tick({0, 0, -0.9e-3}, {0, 0, 0.9});
  EXPECT_EQ(blind.tick({0, 0, -0.9e-3}, {0, 0, 0.8}).z(), 0.8);
}

TEST(QuantizedVelocity, IsAsFineAsAsked) {
  constexpr double kStep = 1e-5, kTick = 1e-3;
  for (const double speed : {1e-3, 7.3e-3, 0.05, 0.2})
    for (const double fine : {1e-3, 2e-3, 1e-2}) {
      QuantizedVelocity velocity(kStep);
      for (int i = 0; i < 100; ++i) {
        velocity.put({0, 0, std::round(speed * i * kTick / kStep) * kStep}, kTick);
        if (i < 2 * QuantizedVelocity::kMostTicks) continue;
        EXPECT_NEAR(velocity.velocity(fine).z(), speed, fine * (1 + 1e-9)) << speed << ' ' << i;
        EXPECT_LE(velocity.window(fine), static_cast<int>(std::ceil(kStep / fine / kTick - 1e-9)));
      }
    }
}

TEST(QuantizedVelocity, ItsWindowEndsWhereThePathTurns) {
  constexpr double kStep = 1e-5;
  QuantizedVelocity velocity(kStep);
  for (int i = 0; i <= 20; ++i) velocity.put({2e-4 * i, 0, 0}, 1e-3);
  EXPECT_EQ(velocity.window(0), QuantizedVelocity::kMostTicks);
  for (int i = 1; i <= 3; ++i) velocity.put({4e-3 - 2e-4 * i, 0, 0}, 1e-3);
  EXPECT_EQ(velocity.window(0), 3);
  EXPECT_NEAR(velocity.velocity(0).x(), -0.2, 1e-12) << "and not the mean of there and back";
  QuantizedVelocity none(kStep);
  EXPECT_TRUE(none.velocity(0).isZero(0));
  none.put({1, 2, 3}, 1e-3);
  EXPECT_TRUE(none.velocity(0).isZero(0));
}

TEST(TurnSum, ItsWayTimesTheTorqueIsTheWork) {
  // Turned evenly about one axis, by more than a whole turn.
  TurnSum about;
  const Vec3 axis = Vec3(1, 2, -2).normalized();
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i <= 1000; ++i) sum = about.add(rotation(0.01 * i * axis));
  EXPECT_LT((sum - 10 * axis).norm(), 1e-11);
  // Random turns, each small: the sum of their rotation vectors, in whichever sign the quaternions come.
  Sample s{std::mt19937_64(8)};
  TurnSum random;
  Quaternion r = rotation(s.cube());
  random.add(r);
  Vec3 want = Vec3::Zero();
  for (int i = 0; i < 200; ++i) {
    const Vec3 turn = 0.02 * s.cube();
    want += turn;
    r = rotation(turn) * r;
    Quaternion shown = r;
    if (i % 2) shown.coeffs() = -shown.coeffs();
    EXPECT_LT((random.add(shown) - want).norm(), 1e-12);
  }
  EXPECT_LT((random.add(r) - want).norm(), 1e-12) << "no turn adds nothing";
}

TEST(MeasuredDelay, IsThe99thPercentileUpToATickAndOneMore) {
  constexpr double kTick = 1e-3;
  EXPECT_EQ(MeasuredDelay(kTick).estimate().delay, MeasuredDelay::kUnknownTicks * kTick);
  EXPECT_FALSE(MeasuredDelay(kTick).estimate().measured);
  Sample s{std::mt19937_64(2)};
  MeasuredDelay delay(kTick), fixed(kTick, 0.4e-3);
  std::vector<double> all;
  for (int i = 0; i < 3 * MeasuredDelay::kWindow; ++i) {
    all.push_back(s.uniform(0.2e-3, 0.9e-3) + (i % 50 == 0 ? 3e-3 : 0));
    delay.add(all.back());
    fixed.add(all.back());
    if (i % 100 == 0) delay.add(i % 200 == 0 ? 0.3 : std::numeric_limits<double>::quiet_NaN());
    if (i % 97 != 0 || i < MeasuredDelay::kEnough) continue;
    std::vector<double> window(all.end() - std::min<std::ptrdiff_t>(MeasuredDelay::kWindow, std::ssize(all)),
                               all.end());
    std::ranges::sort(window);
    const auto at = [&](double share) {
      return window[static_cast<std::size_t>(std::ceil(share * static_cast<double>(window.size()))) - 1];
    };
    const DelayEstimate now = delay.estimate();
    EXPECT_TRUE(now.measured);
    EXPECT_NEAR(now.p50, at(0.5), 1e-9);
    EXPECT_NEAR(now.p99, at(0.99), 1e-9);
    EXPECT_EQ(now.delay, (std::ceil(at(0.99) / kTick) + 1) * kTick);
    EXPECT_EQ(fixed.estimate().delay, 0.4e-3) << "what the user says holds";
    EXPECT_NEAR(fixed.estimate().p99, at(0.99), 1e-9) << "what was measured is told all the same";
  }
  EXPECT_EQ(delay.left_out(), 16);
  MeasuredDelay whole(kTick);
  for (int i = 0; i < 100; ++i) whole.add(1e-3);
  EXPECT_EQ(whole.estimate().delay, 2e-3) << "a whole tick is not two";
}

}  // namespace
}  // namespace kt
