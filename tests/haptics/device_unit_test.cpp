#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "haptics/device/recording.hpp"

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

TEST(LeastDistance, IsThatOfTheSameTime) {
  const std::vector<TimedPoint> there{{0, {0, 0, 0}}, {1, {1, 0, 0}}}, back{{0, {1, 0.1, 0}}, {1, {0, 0.1, 0}}};
  EXPECT_NEAR(least_distance(there, back), 0.1, 1e-15) << "they meet half-way, at no point of either";
  const std::vector<TimedPoint> later{{0, {-0.3, 0, 0}}, {1, {0.7, 0, 0}}};
  EXPECT_NEAR(least_distance(there, later), 0.3, 1e-15) << "the same line, at other times";
  EXPECT_EQ(least_distance(there, {{0, {0, 0, 2}}}), 2);
}

TEST(Scripted, FollowsItsPathWhateverTheForce) {
  const auto device = make_device("scripted", {.path = kPath, .recording = {}});
  device->write({.force = {5, 5, 5}}, 1e-3);
  EXPECT_EQ(device->pose(0.5).x, Vec3(1, 0, 0));
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

TEST_F(RecordedFile, GivesTheRowOfATickBitForBit) {
  const auto device = play("t,x,y,z\n0,0.10000000000000001,0,0\n0.1,0.2,-3e-2,1\n0.2,5,6,7\n");
  EXPECT_EQ(device->pose(0).x, Vec3(0.1, 0, 0));
  EXPECT_EQ(device->pose(0.1).x, Vec3(0.2, -0.03, 1));
  EXPECT_EQ(device->pose(0.1 + 1e-9).x, Vec3(0.2, -0.03, 1)) << "its time differs by rounding";
  EXPECT_EQ(device->pose(0.2).x, Vec3(5, 6, 7));
  EXPECT_EQ(device->pose(7).x, Vec3(5, 6, 7)) << "its end holds";
}

TEST_F(RecordedFile, TakesRowsByTheirTime) {
  const auto slow = play("0,0,0,0\n0.4,4,0,8\n0.8,4,0,0\n");  // a fourth of the ticks
  EXPECT_TRUE(slow->pose(0.1).x.isApprox(Vec3(1, 0, 2)));
  EXPECT_TRUE(slow->pose(0.6).x.isApprox(Vec3(4, 0, 4)));
  const auto fast = play("0,0,0,0\n0.025,9,0,0\n0.05,0,0,0\n0.075,9,0,0\n0.1,1,0,0\n0.15,9,9,9\n0.2,2,0,0\n");
  EXPECT_EQ(fast->pose(0.1).x, Vec3(1, 0, 0));
  EXPECT_EQ(fast->pose(0.2).x, Vec3(2, 0, 0));
  const auto jittered = play("0,0,0,0\n0.09,0.9,0,0\n0.213,2.13,0,0\n0.3,3,0,0\n");
  for (int i = 0; i <= 3; ++i) EXPECT_NEAR(jittered->pose(0.1 * i).x.x(), i, 1e-12);
}

TEST_F(RecordedFile, CountsTimesFromTheFirstRowAndKeepsTheirDigits) {
  // As doubles, times of 1.7e9 s come in steps of 2.4e-7 s.
  const auto device = play("1700000000.0000001,0,0,0\n1700000000.1000001,1,0,0\n1700000000.2000001,4,0,0\n");
  EXPECT_EQ(device->pose(0.1).x, Vec3(1, 0, 0));
  EXPECT_EQ(device->pose(0.2).x, Vec3(4, 0, 0));
  EXPECT_NEAR(read_recording(write("1.7e9,0,0,0\n1700000000.001,1,0,0\n"), 1e-3).path[1].t, 1e-3, 1e-9);
}

TEST_F(RecordedFile, ReadsWhatLoggersAndSpreadsheetsWrite) {
  const std::vector<TimedPoint> wanted{{0, {1, 2, 3}}, {0.1, {4, 5, -6}}};
  for (const char* text :
       {"t,x,y,z\n0,1,2,3\n0.1,4,5,-6\n", "\xef\xbb\xbft,x,y,z\n0,1,2,3\n0.1,4,5,-6\n",
        "# device log\nt,x,y,z\n0,1,2,3\n0.1,4,5,-6\n", "# t,x,y,z\n0.000000e+00,1,2,3\n1.000000e-01,4,5,-6\n",
        "t,x,y,z\r\n0,1,2,3\r\n0.1,4,5,-6\r\n\r\n", "t,x,y,z\r0,1,2,3\r0.1,4,5,-6\r", "0,1,2,3\n\n0.1,4,5,-6\n\n \n",
        "t, x, y, z\n0, 1, 2, 3\n 0.1 ,\t4, 5, -6", "0 1 2 3\n0.1  4 5 -6 \n", "0\t1\t2\t3\n0.1\t4\t5\t-6\n",
        "Time [s];X [m];Y [m];Z [m]\n0;1;2;3\n0.1;4;5;-6\n",
        "\"t\",\"x\",\"y\",\"z\"\n\"0\",\"1\",\"2\",\"3\"\n0.1,4,5,-6\n", "0,1,2,3,\n+0.1,+4,5,-6,\n",
        "z,t,y,x\n3,0,2,1\n-6,0.1,5,4\n"}) {
    const Recording read = read_recording(write(text), 0.1);
    EXPECT_EQ(read.path, wanted) << text;
    EXPECT_TRUE(read.notes.empty()) << text << read.notes.front();
  }
}

TEST_F(RecordedFile, TellsOfColumnsThatAreNotRead) {
  const auto note = [&](const std::string& text) { return read_recording(write(text), 1).notes.at(0); };
  EXPECT_NE(note("t,x,y,z,roll,pitch,yaw\n0,1,2,3,0,0,0\n").find("not read: \"roll\", \"pitch\", \"yaw\""),
            std::string::npos);
  EXPECT_NE(note("0,1,2,3,0,0,0,1\n").find("columns 5 to 8"), std::string::npos) << "w may be first or last";
}

TEST_F(RecordedFile, TakesTheOrientationByItsNames) {
  const std::string rows = "0,1,2,3,0,0,0,1\n1,1,2,3,0,0,0.70710678118654752,0.70710678118654752\n";
  const Recording read = read_recording(write("t,x,y,z,qx,qy,qz,qw\n" + rows), 1);
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_TRUE(read.notes.empty());
  EXPECT_EQ(read.poses[0].pose, (Pose{{1, 2, 3}}));
  EXPECT_LT((read.poses[1].pose.r * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15) << "a quarter about z";
  const auto device = make_device("recorded", {.path = read.path, .poses = read.poses, .h = 1});
  const Vec3 half = device->pose(0.5).r * Vec3::UnitX();
  EXPECT_LT((half - Vec3(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-15) << "half-way it has half turned";
  const auto fails = [&](const std::string& text, const char* words) {
    try {
      read_recording(write(text), 1);
      ADD_FAILURE() << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  };
  fails("t,x,y,z,qw,qx,qy,qz\n0,1,2,3,90,0,0,0\n", ":2: (qw, qx, qy, qz) is (90, 0, 0, 0), of length 90");
  fails("t,x,y,z,qw,qx,qy\n0,1,2,3,1,0,0\n", "an orientation needs all four");
}

TEST_F(RecordedFile, TellsOfRowsFartherApartThanATick) {
  const auto notes = [&](const std::string& text) { return read_recording(write(text), 1e-3).notes; };
  EXPECT_TRUE(notes("0,0,0,0\n0.001,0,0,0\n0.002,0,0,0\n").empty());
  const auto gaps = notes("0,0,0,0\n0.001,0,0,0\n0.036,0,0,0\n0.037,0,0,0\n0.041,0,0,0\n0.042,0,0,0\n");
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_NE(gaps[0].find("than a tick of 1 ms 2 times, usually 1 ms, at most 35 ms before line 3"), std::string::npos)
      << gaps[0];
}

/// Clock times in milliseconds or nanoseconds: read as seconds, the tool would not move.
TEST_F(RecordedFile, RefusesTimesThatAreNotInSeconds) {
  const auto says = [&](const std::string& text) -> std::string {
    try {
      read_recording(write(text), 1e-3);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  const auto rows = [](double step, double way) {
    std::string out;
    for (int i = 0; i < 30; ++i) out += std::to_string(1.7e9 + step * i) + ',' + std::to_string(way * i) + ",0,0\n";
    return out;
  };
  EXPECT_NE(says(rows(4, 2e-4)).find("the 30 rows are usually 4 s apart, and the tool moves at 5e-05 m/s"),
            std::string::npos);  // 50 mm/s at 250 Hz, in milliseconds
  EXPECT_EQ(says(rows(4, 0.02)), "") << "a robot's way";
  EXPECT_EQ(says(rows(4, 0)), "") << "a tool at rest";
  EXPECT_EQ(says(rows(0.2, 2e-5)), "");
  EXPECT_NE(says("0,0,0,0\n0.001,0,0,0\n1.7e9,0,0,0\n").find(":3: time \"1.7e9\" s is 1.7e+09 s behind"),
            std::string::npos);
  EXPECT_NE(says("-1e308,0,0,0\n0,0,0,0\n0.001,0,0,0\n").find(":2: time \"0\" s is 1e+308 s behind"),
            std::string::npos);
  EXPECT_EQ(says("0,0,0,0\n0.001,0,0,0\n" + std::string(5, '\0')), "") << "what a logger that lost its power left";
}

TEST_F(RecordedFile, SpeedIsThatFromTickToTick) {
  EXPECT_NEAR(play("0,0,0,0\n1,2,0,0\n1.1,2,1,0\n")->max_speed(), 10, 1e-9);
  // 1 mm of noise within a hundredth of a tick is no speed that a tick could see.
  EXPECT_LT(play("0,0,0,0\n0.5,1,0,0\n0.501,1.001,0,0\n0.502,1,0,0\n1,2,0,0\n")->max_speed(), 2.1);
}

TEST_F(RecordedFile, BadFilesAreNamedWithTheirLineAndValue) {
  const auto says = [&](const std::string& text, std::initializer_list<const char*> words) {
    const std::string found = refusal(text);
    for (const char* word : words) EXPECT_NE(found.find(word), std::string::npos) << text << " gives " << found;
    EXPECT_EQ(found.find('\n'), std::string::npos);
  };
  says("", {"empty"});
  says("t,x,y,z\n", {"empty"});
  says("# nothing\n\n", {"empty"});
  says("0,1,2,3\n0.1,1,2\n", {":2:", "3 values", "\"t,x,y,z\""});
  says("0,1,2,x\n", {":1:", "z \"x\" is not a number"});
  says("t,x,y,z\n\n# three\n0,1,2,nan\n", {":4:", "nan"});
  says("0,1,2,inf\n", {":1:", "inf"});
  says("0,1,2,1e999\n", {":1:", "1e999"});
  says("0,1,2,1e200\n", {":1:", "z is \"1e200\""});
  says("0,1,,3\n", {":1:", "y \"\""});
  says("0;0,5;1;2\n", {":1:", "\"0,5\"", "decimal point"});
  says("0,1,2,3\n0.2,1,2,3\nt,x,y,z\n", {":3:", "\"t\""});
  says("0,1,2,3\n0,1,2,3\n", {":2:", "\"0\" s does not follow", "\"0\""});
  says("1700000000.2,1,2,3\n1700000000.1,1,2,3\n", {":2:", "\"1700000000.1\"", "\"1700000000.2\""});
  says("t_ms,x,y,z\n0,1,2,3\n", {":1:", "named t among \"t_ms\"", "in s and m"});
  says("junk\xff\x01\n", {":1:", "junk??"});
  EXPECT_THROW(make_device("recorded", {.path = {}, .recording = "/no/such/file"}), InputError);
  EXPECT_THROW(make_device("recorded", {.path = {}, .recording = "/dev/null"}), InputError);
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
    hand->write({.force = {force, 0, 0}}, h);
    const double t = i * h;
    const double exact = force / o.hand_stiffness *
                         (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    worst = std::max(worst, std::abs(hand->pose(t).x.x() - exact));
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
      hand->write({.force = {1, 0, 0}}, 0.5e-3);
      at.push_back(hand->pose(0).x);
    }
    for (int i = 0; i < 60; ++i) delayed->write({.force = {1, 0, 0}}, 1e-3);
    const auto then = static_cast<std::size_t>(2 * 60 - 2 * ticks) - 1;
    EXPECT_LT((delayed->pose(0).x - at[then]).norm(), 1e-15);
  }
}

TEST(Hand, NoDampingIsTooStrongForIt) {
  DeviceOptions o = hand_options();
  for (double damping : {0.0, 2 * std::sqrt(o.hand_stiffness * o.hand_mass), 1e5}) {
    o.hand_damping = damping;
    const auto hand = make_device("hand", o);
    for (int i = 0; i < 100; ++i) {
      hand->write({.force = {1, 0, 0}}, 1e-3);
      EXPECT_TRUE(hand->pose(0).x.allFinite());
      EXPECT_LE(hand->pose(0).x.x(), 2 * 1 / o.hand_stiffness * (1 + 1e-12)) << damping;
    }
  }
}

TEST(Hand, ComesToRestWhereSpringAndForceBalance) {
  const auto hand = make_device("hand", hand_options());
  for (int i = 0; i < 3000; ++i) hand->write({.force = {0, 0, 2}}, 1e-3);
  EXPECT_LT((hand->pose(3).x - Vec3(0, 0, 2.0 / 200)).norm(), 1e-12);
}

TEST(Hand, FollowsAMovingTargetWithoutLagWhenNothingPushes) {
  DeviceOptions o = hand_options();
  o.path = {{0, {0, 0, 0}}, {2, {0.2, 0, 0}}};
  const auto hand = make_device("hand", o);
  for (int i = 0; i < 1500; ++i) hand->write({.force = Vec3::Zero()}, 1e-3);
  EXPECT_LT((hand->pose(1.5).x - Vec3(0.15, 0, 0)).norm(), 1e-9) << "the damper acts against the target's velocity";
}

TEST(Hand, IsReadInMultiplesOfTheEncoderStep) {
  DeviceOptions o = hand_options();
  o.encoder_step = 1e-5;
  const auto exact = make_device("hand", hand_options()), read = make_device("hand", o);
  for (int i = 0; i < 200; ++i) {
    exact->write({.force = {1, -0.7, 0.3}}, 1e-3);
    read->write({.force = {1, -0.7, 0.3}}, 1e-3);
    const Vec3 p = read->pose(0).x;
    for (double x : p) EXPECT_NEAR(x / 1e-5, std::round(x / 1e-5), 1e-9);
    EXPECT_LE((p - exact->pose(0).x).lpNorm<Eigen::Infinity>(), 0.5e-5 * (1 + 1e-9));
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

TEST(SafeForce, OfAnyFiniteForceIsTheLimitInItsDirectionAndNeverMore) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> component(-1, 1), exponent(-160, 300);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 way = Vec3(component(random), component(random), component(random)).normalized();
    const double limit = std::pow(10, exponent(random)), size = limit * std::pow(10, 1 + std::abs(exponent(random)));
    if (!(size < 1e307)) continue;
    bool limited = false;
    const Vec3 out = safe_force(size * way, {limit}, limited);
    ASSERT_TRUE(limited);
    ASSERT_LE(out.stableNorm(), limit);
    ASSERT_LE(std::hypot(out.x(), out.y(), out.z()), limit);
    ASSERT_LT((out - limit * way).lpNorm<Eigen::Infinity>(), 1e-14 * limit) << limit << ' ' << size;
  }
  bool limited = false;
  EXPECT_TRUE(safe_force({0, 1e200, 0}, {7.9}, limited).isApprox(Vec3(0, 7.9, 0)));
  EXPECT_TRUE(safe_force({1.7e308, 1.7e308, 1.7e308}, {3}, limited).isApprox(Vec3::Constant(std::sqrt(3))));
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
    ASSERT_LE(out.stableNorm(), limit) << force.transpose() << " limit " << limit;
    if (!force.allFinite()) {
      ASSERT_TRUE(limited && out.isZero(0)) << force.transpose() << " limit " << limit;
    } else if (!limited) {
      ASSERT_EQ(out, force);
    }
  }
}

}  // namespace
}  // namespace kt
