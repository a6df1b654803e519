// Whatever is asked for, by whatever device: what is written is finite, within its limits, and zero in time.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "haptics/guard/safety_chain.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-9;

DeviceInfo live(double max_force = 7.9) {
  DeviceInfo out;
  out.is_live = out.yields = out.gives_torque = true;
  out.max_force = max_force;
  out.max_torque = 0.2;
  return out;
}

LocalFrame asking(const Vec3& force) {
  LocalFrame out;
  out.force = force;
  return out;
}

/// Any number, and what is none.
class Wild {
 public:
  explicit Wild(unsigned seed) : random_(seed) {}
  double number(double usual) {
    const int kind = uniform(60);
    if (kind == 0) return std::numeric_limits<double>::quiet_NaN();
    if (kind == 1) return std::numeric_limits<double>::infinity();
    if (kind == 2) return -std::numeric_limits<double>::max();
    if (kind == 3) return 1e-310;
    if (kind < 8) return 1e6 * normal_(random_);
    return usual * normal_(random_);
  }
  Vec3 vector(double usual) { return {number(usual), number(usual), number(usual)}; }
  Vec3 place() {
    return (uniform(20000) == 0 ? 1e-2 : 5e-5) * Vec3(normal_(random_), normal_(random_), normal_(random_));
  }
  int uniform(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  double share() { return std::uniform_real_distribution<double>(0, 1)(random_); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

/// Random wrenches, poses, ages, flags, buttons, faults and stalls, a million ticks over several devices.
TEST(SafetyChain, WhateverComesTheForceIsFiniteLimitedSlewedAndZeroInTime) {
  Wild wild(7);
  int opened = 0, zeroed = 0;
  for (int device = 0; device < 20; ++device) {
    SafetyOptions o;
    if (device % 2 == 0) o.coupling = 0;
    o.device = live(device % 3 == 0 ? std::numeric_limits<double>::infinity() : 1 + 0.5 * device);
    o.device.continuous_force = device % 4 == 0 ? 0.4 : 0;
    o.h = device % 5 == 0 ? 2.5e-4 : device % 5 == 1 ? 4e-3 : 1e-3;
    o.most_damping = device % 2 == 0 ? 20 : 0;
    o.max_slew = device % 7 == 0 ? 20 : 200;
    o.scale = device % 3 == 1 ? 4 : 1;
    o.force_scale = device % 3 == 2 ? 0.25 : 1;
    if (device % 6 == 5) o.max_force = 2;
    o.deadman = device % 8 == 3 ? 1 : 0;
    SafetyChain chain(o);
    const double limit = std::min(o.device.max_force, o.max_force.value_or(3));
    ASSERT_EQ(chain.max_force(), limit);
    const double closing = std::max(o.h, SafetyChain::kZeroWithin - 5e-3 - 2 * o.h);
    Vec3 before = Vec3::Zero();
    double fresh_age = 0;  // [s] since the last fresh pose, by the times of the ticks
    int spell = 0;         // ticks until the kind of trouble changes
    int trouble = 0;
    const int ticks = 50000;
    for (int i = 0; i < ticks; ++i) {
      if (--spell <= 0) {
        trouble = wild.uniform(3) > 0 ? 0 : wild.uniform(8);
        spell = 1 + wild.uniform(static_cast<int>((trouble == 0 ? 1.5 : 0.08) / o.h));
      }
      double dt = o.h * (0.5 + wild.share());
      if (wild.uniform(500) == 0) dt = 0.05 * wild.share();  // the tick was held up
      if (trouble == 7) dt = 3 * o.h;
      LocalFrame frame = asking(wild.vector(3));
      frame.torque = wild.vector(0.1);
      if (trouble == 6) frame.flags = 1u << wild.uniform(12);
      DeviceState state;
      state.buttons = trouble == 5 ? 0 : 1;
      if (trouble >= 1 && trouble <= 4) {
        fresh_age += dt;
        state.health = std::array{DeviceHealth::stale, DeviceHealth::gone, DeviceHealth::fault,
                                  DeviceHealth::ok}[static_cast<std::size_t>(trouble - 1)];
        state.age = fresh_age;
        // An age up to 5 ms is no trouble yet.
        if (fresh_age <= 5e-3) state.health = DeviceHealth::ok;
      } else {
        fresh_age = 0;
      }
      Pose pose{wild.place(), Quaternion::Identity()};
      if (trouble == 4 && fresh_age > 5e-3) pose.x.y() = std::numeric_limits<double>::quiet_NaN();
      const Pose tool = chain.tool(pose, dt);
      ASSERT_EQ(tool.is_finite(), pose.is_finite());
      const Wrench out = chain.make_safe(frame, pose, state, dt);
      ASSERT_TRUE(out.force.allFinite() && out.torque.allFinite()) << device << ' ' << i;
      ASSERT_LE(out.force.norm(), limit) << device << ' ' << i;
      ASSERT_LE(out.torque.norm(), 0.2 * (1 + kRoundoff)) << device << ' ' << i;
      ASSERT_TRUE(frame.force.isApprox(out.force / o.force_scale)) << "booked is what was written";
      const double step = (out.force - before).norm();
      if (dt < SafetyChain::kZeroWithin) {  // else the driver has written zero meanwhile
        const bool shuts = chain.reason() != GateReason::open;
        const double slew = shuts ? std::max(o.max_slew, limit / closing) : o.max_slew;
        ASSERT_LE(step, slew * (shuts ? dt : std::min(dt, o.h)) * (1 + kRoundoff) + 1e-12) << device << ' ' << i;
      }
      if (fresh_age >= SafetyChain::kZeroWithin) {
        ASSERT_TRUE(out.force.isZero(0) && out.torque.isZero(0)) << device << ' ' << i << ": " << fresh_age << " s";
        ++zeroed;
      }
      opened += chain.gate() == 1;
      before = out.force;
    }
  }
  EXPECT_GT(opened, 50000) << "the gate was open for some of it";
  EXPECT_GT(zeroed, 5000) << "poses were away for long enough";
}

/// Opens over half a second, and a fresh start after trouble is as gentle.
TEST(SafetyChain, TheGateOpensSlowlyAndShutsWithin20ms) {
  SafetyOptions o;
  o.coupling = 0;
  o.device = live(3);
  SafetyChain chain(o);
  const auto tick = [&](double age) {
    LocalFrame frame = asking({0, 0, 2});
    return chain.make_safe(frame, {}, {.age = age}, 1e-3).force.z();
  };
  EXPECT_LE(tick(0), 2 * 1e-3 / 0.5 + kRoundoff);
  for (int i = 1; i < 250; ++i) tick(0);
  EXPECT_NEAR(tick(0), 1, 0.01) << "half open after half of its time";
  for (int i = 0; i < 260; ++i) tick(0);
  EXPECT_NEAR(tick(0), 2, 1e-12);
  EXPECT_EQ(chain.reason(), GateReason::open);
  int ticks = 0;
  for (double age = 1e-3; tick(age) > 0; age += 1e-3) ++ticks;
  EXPECT_LE(ticks, 20);
  EXPECT_GE(ticks, 5) << "a pose that is a few ticks old is none that is lost";
  EXPECT_EQ(chain.reason(), GateReason::stale_pose);
  EXPECT_LE(tick(0), 2 * 1e-3 / 0.5 + kRoundoff) << "from the start again";
}

/// A handle on a torsion spring that is held over each tick swings up by itself.
/// @return largest turn of the last half second [rad], and energy that the handle was given at most [J]
struct Swing {
  double turn = 0, given = 0;
};
Swing turned_by_a_spring(double most_damping) {
  constexpr double kInertia = 1e-4, kSpring = 1.5, kStart = 0.02;  // [kg m^2], [N m/rad], [rad]
  constexpr int kPieces = 20;
  SafetyOptions o;
  o.coupling = 0;
  o.device = live(3);
  o.most_damping = most_damping;
  o.delay = 0;
  SafetyChain chain(o);
  double angle = kStart, rate = 0, work = 0;
  Swing out;
  for (int tick = 0; tick < 4000; ++tick) {
    const bool is_free = chain.gate() == 1;  // until then it is held
    LocalFrame frame;
    frame.torque = Vec3(0, 0, -kSpring * angle);
    const Pose pose{Vec3::Zero(), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitZ()))};
    const double torque = chain.make_safe(frame, pose, {}, 1e-3).torque.z();
    EXPECT_LE(std::abs(torque), o.device.max_torque * (1 + kRoundoff));
    const double before = angle;
    for (int i = 0; is_free && i < kPieces; ++i) {
      rate += torque / kInertia * 1e-3 / kPieces;
      angle += rate * 1e-3 / kPieces;
    }
    work += torque * (angle - before);
    out.given = std::max(out.given, work - 0.5 * kSpring * kStart * kStart);
    if (tick > 3500) out.turn = std::max(out.turn, std::abs(angle));
  }
  return out;
}

TEST(SafetyChain, ATorqueGivesNoEnergyEither) {
  const Swing watched = turned_by_a_spring(0), controlled = turned_by_a_spring(20);
  EXPECT_GT(watched.turn, 0.1) << "without control it swings up to where the torque is cut";
  EXPECT_LT(controlled.turn, 0.02);
  EXPECT_LT(controlled.given, 0.1 * watched.given);
}

/// Energy is counted of what was written, not of what was asked for: see the observer's own tests for the rest.
TEST(SafetyChain, WarmMotorsAreGivenWhatTheyCanBear) {
  SafetyOptions o;
  o.coupling = 0;
  o.device = live(3);
  o.device.continuous_force = 1;
  SafetyChain chain(o);
  double first = 0, last = 0;
  for (int i = 0; i < 60000; ++i) {
    LocalFrame frame = asking({0, 0, 3});
    last = chain.make_safe(frame, {}, {}, 1e-3).force.z();
    if (i == 600) first = last;
  }
  EXPECT_NEAR(first, 3, 1e-6);
  EXPECT_NEAR(last, 1, 0.06) << "after a minute";
  for (int i = 0; i < 30000; ++i) {
    LocalFrame frame = asking({0, 0, 0});
    chain.make_safe(frame, {}, {}, 1e-3);
  }
  LocalFrame frame = asking({0, 0, 3});
  for (int i = 0; i < 20; ++i) {
    frame = asking({0, 0, 3});
    last = chain.make_safe(frame, {}, {}, 1e-3).force.z();
  }
  EXPECT_NEAR(last, 3, 1e-6) << "cold again";
}

/// After a gap, and at the start, the tool goes to the device at a speed that local models follow, the gate shut.
TEST(SafetyChain, TheToolFollowsWhatItMissed) {
  SafetyOptions o;
  o.coupling = 0;
  o.device = live(3);
  SafetyChain chain(o);
  chain.begin_at({0, 0, 0.01});
  Vec3 before(0, 0, 0.01);
  int ticks = 0;
  const auto tick = [&](const Vec3& x, DeviceState state) {
    const Vec3 tool = chain.tool({x, Quaternion::Identity()}, 1e-3).x;
    LocalFrame frame = asking({0, 0, 1});
    chain.make_safe(frame, {x, Quaternion::Identity()}, state, 1e-3);
    EXPECT_LE((tool - before).norm(), SafetyChain::kFollows * 1e-3 + kRoundoff);
    before = tool;
    return tool;
  };
  for (; ticks < 100 && !tick({0, 0, 0}, {}).isZero(0); ++ticks) EXPECT_EQ(chain.gate(), 0) << ticks;
  EXPECT_NEAR(ticks, 39, 1) << "10 mm at 0.25 m/s";
  for (int i = 0; i < 600; ++i) tick({0, 0, 0}, {});
  EXPECT_EQ(chain.gate(), 1);
  for (int i = 0; i < 50; ++i) tick({0, 0, 0}, {.health = DeviceHealth::gone});
  EXPECT_EQ(tick({0.05, 0, 0}, {}).y(), 0) << "it comes back elsewhere";
  EXPECT_EQ(chain.reason(), GateReason::on_the_way);
  for (int i = 0; i < 205; ++i) tick({0.05, 0, 0}, {});
  EXPECT_EQ(before, Vec3(0.05, 0, 0));
  EXPECT_EQ(chain.reason(), GateReason::open);
}

/// A hand that is simulated is given nothing either where its body's computer is gone, and gets its force back slowly.
TEST(SafetyChain, OverANetworkAForceOfStaleModelsFadesForThoseThatNobodyHolds) {
  for (const bool fades : {true, false}) {
    SafetyOptions o;
    o.fades_when_stale = fades;
    SafetyChain chain(o);
    const auto tick = [&](unsigned flags) {
      LocalFrame frame = asking({0, 0, 1});
      frame.flags = flags;
      const Wrench out = chain.make_safe(frame, {}, {}, 1e-3);
      EXPECT_EQ(out.force, frame.force);
      EXPECT_EQ((frame.flags & kGated) != 0, chain.gate() < 1);
      return out.force.z();
    };
    EXPECT_EQ(tick(0), 1);
    for (int i = 0; i < 20; ++i) tick(kStaleModel);
    EXPECT_EQ(tick(kStaleModel), fades ? 0 : 1);
    EXPECT_EQ(tick(kBodyFailed), fades ? 0 : 1);
    double before = tick(0);
    for (int i = 0; i < 600; ++i) {
      const double now = tick(0);
      EXPECT_LE(now - before, 1e-3 / SafetyChain::kOpening + 1e-12);
      before = now;
    }
    EXPECT_EQ(before, 1);
  }
}

/// Who is not there, or asks for nothing, is given nothing; and each reason has its name.
TEST(SafetyChain, EachReasonShutsTheGate) {
  struct Case {
    GateReason reason;
    DeviceState state;
    unsigned flags;
  };
  const Case cases[] = {{GateReason::stale_pose, {.health = DeviceHealth::stale, .buttons = 1}, 0},
                        {GateReason::stale_pose, {.age = 6e-3, .buttons = 1}, 0},
                        {GateReason::stale_pose, {.age = -1, .buttons = 1}, 0},
                        {GateReason::stale_pose, {.age = NAN, .buttons = 1}, 0},
                        {GateReason::bad_pose, {.buttons = 1}, kBadPose},
                        {GateReason::bad_pose, {.health = DeviceHealth::bad_pose, .buttons = 1}, 0},
                        {GateReason::unpowered, {.health = DeviceHealth::unpowered, .buttons = 1}, 0},
                        {GateReason::not_ready, {.health = DeviceHealth::not_ready, .buttons = 1}, 0},
                        {GateReason::in_use, {.health = DeviceHealth::in_use, .buttons = 1}, 0},
                        {GateReason::altered, {.health = DeviceHealth::altered, .buttons = 1}, 0},
                        {GateReason::no_echo, {.health = DeviceHealth::no_echo, .buttons = 1}, 0},
                        {GateReason::gone, {.health = DeviceHealth::gone, .buttons = 1}, 0},
                        {GateReason::fault, {.health = DeviceHealth::fault, .buttons = 1}, 0},
                        {GateReason::uncalibrated, {.health = DeviceHealth::uncalibrated, .buttons = 1}, 0},
                        {GateReason::button, {.buttons = 2}, 0},
                        {GateReason::stale_model, {.buttons = 1}, kStaleModel},
                        {GateReason::stale_model, {.buttons = 1}, kBodyFailed},
                        {GateReason::open, {.buttons = 1}, kPushedOut}};
  for (const Case& c : cases) {
    SafetyOptions o;
    o.coupling = 0;
    o.device = live();
    o.deadman = 1;
    SafetyChain chain(o);
    for (int i = 0; i < 600; ++i) {
      LocalFrame frame = asking({0, 0, 1});
      chain.make_safe(frame, {}, {.buttons = 1}, 1e-3);
    }
    ASSERT_EQ(chain.gate(), 1);
    Wrench out;
    for (int i = 0; i < 25; ++i) {
      LocalFrame frame = asking({0, 0, 1});
      frame.flags = c.flags;
      out = chain.make_safe(frame, {}, c.state, 1e-3);
    }
    EXPECT_EQ(chain.reason(), c.reason) << name_of(c.reason);
    EXPECT_EQ(out.force.isZero(0), c.reason != GateReason::open) << name_of(c.reason);
    EXPECT_FALSE(std::string(name_of(c.reason)).empty());
  }
}

}  // namespace
}  // namespace kt
