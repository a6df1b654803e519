#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "haptics/device/haptic_device.hpp"

namespace kt {
namespace {

const std::vector<TimedPoint> kPath{{0, {0, 0, 0}}, {1, {2, 0, 0}}, {1.5, {2, 4, 0}}};

TEST(InterpolatePath, IsLinearBetweenPointsAndHoldsItsEnds) {
  EXPECT_EQ(interpolate_path(kPath, -1), Vec3(0, 0, 0));
  EXPECT_EQ(interpolate_path(kPath, 0), Vec3(0, 0, 0));
  EXPECT_EQ(interpolate_path(kPath, 0.25), Vec3(0.5, 0, 0));
  EXPECT_EQ(interpolate_path(kPath, 1), Vec3(2, 0, 0));
  EXPECT_EQ(interpolate_path(kPath, 1.25), Vec3(2, 2, 0));
  EXPECT_EQ(interpolate_path(kPath, 1.5), Vec3(2, 4, 0));
  EXPECT_EQ(interpolate_path(kPath, 99), Vec3(2, 4, 0));
}

TEST(PathSpeed, IsThatOfTheFastestPiece) {
  EXPECT_EQ(path_speed(kPath), 8);
  EXPECT_EQ(path_speed({{0, {1, 1, 1}}}), 0);
}

TEST(Scripted, FollowsItsPathWhateverTheForce) {
  const auto device = make_device("scripted", {.path = kPath, .recording = {}});
  device->write({5, 5, 5}, 1e-3);
  EXPECT_EQ(device->position(0.5), Vec3(1, 0, 0));
  EXPECT_EQ(device->max_speed(), 8);
}

TEST(Scripted, RefusesPathsThatAreNone) {
  const auto make = [](std::vector<TimedPoint> path) { make_device("scripted", {.path = path, .recording = {}}); };
  EXPECT_THROW(make({}), InputError);
  EXPECT_THROW(make({{0, {0, 0, 0}}, {0, {1, 0, 0}}}), InputError);
  EXPECT_THROW(make({{0, {0, NAN, 0}}}), InputError);
  EXPECT_THROW(make({{INFINITY, {0, 0, 0}}}), InputError);
}

/// A recording with the given text, gone at the end of the test.
class RecordedFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    std::ofstream(file_) << text;
    return file_.string();
  }
  std::unique_ptr<HapticDevice> play(const std::string& text) {
    return make_device("recorded", {.path = {}, .recording = write(text), .h = 0.1});
  }
  std::string refusal(const std::string& text) {
    try {
      play(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  void TearDown() override { std::filesystem::remove(file_); }
  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() /
      ("kt_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".csv");
};

TEST_F(RecordedFile, GivesOnePositionATickBitForBit) {
  const auto device = play("t,x,y,z\n0,0.10000000000000001,0,0\n0.1,0.2,-3e-2,1\n0.2,5,6,7\n");
  EXPECT_EQ(device->position(0), Vec3(0.1, 0, 0));
  EXPECT_EQ(device->position(0.1), Vec3(0.2, -0.03, 1));
  EXPECT_EQ(device->position(0.1 + 1e-9), Vec3(0.2, -0.03, 1)) << "no interpolation";
  EXPECT_EQ(device->position(0.2), Vec3(5, 6, 7));
  EXPECT_EQ(device->position(7), Vec3(5, 6, 7)) << "its end holds";
}

TEST_F(RecordedFile, BadFilesAreNamedWithTheirLine) {
  EXPECT_NE(refusal("").find("empty"), std::string::npos);
  EXPECT_NE(refusal("t,x,y,z\n").find("empty"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,3\n0.1,1,2\n").find(":2:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,x\n").find(":1:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,nan\n").find(":1:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,inf\n").find(":1:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,1e999\n").find(":1:"), std::string::npos);
  EXPECT_NE(refusal("0 1 2 3\n").find(":1:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,3\n\n0.1,1,2,3\n").find(":2:"), std::string::npos);
  EXPECT_NE(refusal("0,1,2,3\n0,1,2,3\n").find("does not follow"), std::string::npos);
  EXPECT_THROW(make_device("recorded", {.path = {}, .recording = "/no/such/file"}), InputError);
}

DeviceOptions hand_options() {
  DeviceOptions o;
  o.path = {{0, {0, 0, 0}}};
  o.hand_stiffness = 200;
  o.hand_damping = 4;
  o.hand_mass = 0.1;
  o.encoder_step = 0;
  return o;
}

/// Largest distance from the exact answer of the oscillator to a constant force from rest, over one second.
double step_response_error(double h) {
  const DeviceOptions o = hand_options();
  const auto hand = make_device("hand", o);
  const double force = 1, decay = o.hand_damping / (2 * o.hand_mass);
  const double omega = std::sqrt(o.hand_stiffness / o.hand_mass - decay * decay);
  double worst = 0;
  for (int i = 1; i * h <= 1; ++i) {
    hand->write({force, 0, 0}, h);
    const double t = i * h;
    const double exact = force / o.hand_stiffness *
                         (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    worst = std::max(worst, std::abs(hand->position(t).x() - exact));
  }
  return worst;
}

TEST(Hand, AnswersAForceLikeTheOscillatorThatItIs) {
  for (double h : {1e-2, 1e-3, 0.5e-3}) EXPECT_LT(step_response_error(h), 1e-12 * (1 / 200.0)) << "exact at any step";
}

TEST(Hand, FeelsAForceAfterItsDelay) {
  DeviceOptions o = hand_options(), late = o;
  for (double ticks : {1.0, 2.5}) {
    late.hand_delay = ticks * 1e-3;
    const auto hand = make_device("hand", o), delayed = make_device("hand", late);
    // Half ticks: the delayed hand is where the other one was, so much earlier.
    std::vector<Vec3> at;
    for (int i = 0; i < 200; ++i) {
      hand->write({1, 0, 0}, 0.5e-3);
      at.push_back(hand->position(0));
    }
    for (int i = 0; i < 60; ++i) delayed->write({1, 0, 0}, 1e-3);
    const auto then = static_cast<std::size_t>(2 * 60 - 2 * ticks) - 1;
    EXPECT_LT((delayed->position(0) - at[then]).norm(), 1e-15);
  }
}

TEST(Hand, NoDampingIsTooStrongForIt) {
  DeviceOptions o = hand_options();
  for (double damping : {0.0, 2 * std::sqrt(o.hand_stiffness * o.hand_mass), 1e5}) {
    o.hand_damping = damping;
    const auto hand = make_device("hand", o);
    for (int i = 0; i < 100; ++i) {
      hand->write({1, 0, 0}, 1e-3);
      EXPECT_TRUE(hand->position(0).allFinite());
      EXPECT_LE(hand->position(0).x(), 2 * 1 / o.hand_stiffness * (1 + 1e-12)) << damping;
    }
  }
}

TEST(Hand, ComesToRestWhereSpringAndForceBalance) {
  const auto hand = make_device("hand", hand_options());
  for (int i = 0; i < 3000; ++i) hand->write({0, 0, 2}, 1e-3);
  EXPECT_LT((hand->position(3) - Vec3(0, 0, 2.0 / 200)).norm(), 1e-12);
}

TEST(Hand, FollowsAMovingTargetWithoutLagWhenNothingPushes) {
  DeviceOptions o = hand_options();
  o.path = {{0, {0, 0, 0}}, {2, {0.2, 0, 0}}};
  const auto hand = make_device("hand", o);
  for (int i = 0; i < 1500; ++i) hand->write(Vec3::Zero(), 1e-3);
  EXPECT_LT((hand->position(1.5) - Vec3(0.15, 0, 0)).norm(), 1e-9) << "the damper acts against the target's velocity";
}

TEST(Hand, IsReadInMultiplesOfTheEncoderStep) {
  DeviceOptions o = hand_options();
  o.encoder_step = 1e-5;
  const auto exact = make_device("hand", hand_options()), read = make_device("hand", o);
  for (int i = 0; i < 200; ++i) {
    exact->write({1, -0.7, 0.3}, 1e-3);
    read->write({1, -0.7, 0.3}, 1e-3);
    const Vec3 p = read->position(0);
    for (double x : p) EXPECT_NEAR(x / 1e-5, std::round(x / 1e-5), 1e-9);
    EXPECT_LE((p - exact->position(0)).lpNorm<Eigen::Infinity>(), 0.5e-5 * (1 + 1e-9));
  }
}

TEST(Hand, RefusesWhatCannotMove) {
  DeviceOptions o = hand_options();
  o.hand_mass = 0;
  EXPECT_THROW(make_device("hand", o), InputError);
  o = hand_options();
  o.path.clear();
  EXPECT_THROW(make_device("hand", o), InputError);
}

TEST(SafeForce, LetsSmallForcesPassUntouched) {
  bool limited = true;
  EXPECT_EQ(safe_force({1, 2, 2}, {3}, limited), Vec3(1, 2, 2));
  EXPECT_FALSE(limited);
  EXPECT_EQ(safe_force({1e9, 0, 0}, {}, limited), Vec3(1e9, 0, 0)) << "no limit";
  EXPECT_FALSE(limited);
}

TEST(SafeForce, ShortensTheForceToTheLimit) {
  bool limited = false;
  EXPECT_TRUE(safe_force({2, 4, 4}, {3}, limited).isApprox(Vec3(1, 2, 2)));
  EXPECT_TRUE(limited);
}

TEST(SafeForce, WritesNothingWrongWhateverTheBits) {
  std::mt19937_64 random(3);
  const double special[] = {0,      -0.0,   NAN,     INFINITY, -INFINITY, 5e-324, -5e-324, 2e-308,
                            1e-200, 1e-160, 1.7e308, -1.7e308, 1e154,     1e155,  1,       -1};
  const double limits[] = {0, 5e-324, 1e-200, 0.1, 7.9, 1e200, INFINITY};
  const auto value = [&] {
    if (random() % 3 == 0) return special[random() % std::size(special)];
    const std::uint64_t bits = random();
    double out;
    std::memcpy(&out, &bits, sizeof out);
    return out;
  };
  for (int i = 0; i < 1000000; ++i) {
    const Vec3 force(value(), value(), value());
    const double limit = limits[random() % std::size(limits)];
    bool limited = false;
    const Vec3 out = safe_force(force, {limit}, limited);
    ASSERT_TRUE(out.allFinite()) << force.transpose() << " limit " << limit;
    // norm(): below 1e-160 N the squares vanish, and such a force counts as none.
    ASSERT_LE(out.norm(), limit * (1 + 1e-12)) << force.transpose() << " limit " << limit;
    if (!std::isfinite(force.norm())) {
      ASSERT_TRUE(limited && out.isZero(0)) << force.transpose() << " limit " << limit;
    } else if (!limited) {
      ASSERT_EQ(out, force);
    }
  }
}

}  // namespace
}  // namespace kt
