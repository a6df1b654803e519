// Force metrics of made-up force histories against what they must be.
#include "haptics/session/metrics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kt {
namespace {

constexpr double kStep = 1e-3;  // [s]

/// |H|^2 of the Butterworth filter run forward and backward: 1 / (1 + (tan(pi fc/fs) / tan(pi f/fs))^4).
double gain(double f, double cutoff, double rate) {
  const double k = std::tan(std::numbers::pi * cutoff / rate) / std::tan(std::numbers::pi * f / rate);
  return 1 / (1 + k * k * k * k);
}

std::vector<double> sine(double hz, int count) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(std::sin(2 * std::numbers::pi * hz * i * kStep));
  return out;
}

/// Ticks in sliding contact with a force of 2 N up and `wave` sideways.
std::vector<LocalFrame> contact(const std::vector<double>& wave) {
  std::vector<LocalFrame> out;
  for (std::size_t i = 0; i < wave.size(); ++i) {
    LocalFrame f;
    f.t = static_cast<double>(i + 1) * kStep;
    f.force = {wave[i], 0, 2};
    f.normal = Vec3::UnitZ();
    f.f_n = 2;
    f.f_t = std::abs(wave[i]);
    f.cone_ratio = f.f_t / f.f_n;
    f.mode = ContactMode::frictional_slide;
    f.triangle = 0;
    out.push_back(f);
  }
  return out;
}

TEST(HighPass, HasTheAnalyticGainAndNoDelay) {
  for (double hz : {20.0, 50.0, 100.0, 200.0, 400.0}) {
    const auto in = sine(hz, 4000), out = high_pass(in, 100, 1 / kStep);
    for (std::size_t i = 1000; i < 3000; ++i) ASSERT_NEAR(out[i], gain(hz, 100, 1 / kStep) * in[i], 1e-6) << hz;
  }
}

TEST(HighPass, LeavesNothingOfAConstantOrWithoutRoomAboveTheCutoff) {
  for (double y : high_pass(std::vector<double>(100, 3.0), 100, 1000)) EXPECT_EQ(y, 0);
  for (double y : high_pass(sine(20, 100), 100, 150)) EXPECT_EQ(y, 0);
  EXPECT_TRUE(high_pass({}, 100, 1000).empty());
}

TEST(Buzz, IsTheRmsAbove100HzOverTheMeanForce) {
  constexpr double kEnds = 0.01;  // the filter starts and stops: 2 of 4000 ms
  for (double hz : {200.0, 100.0, 20.0}) {
    const auto wave = sine(hz, 4000);
    double mean = 0;
    for (double y : wave) mean += std::hypot(y, 2) / 4000;
    const double expected = gain(hz, 100, 1 / kStep) * std::sqrt(0.5) / mean;
    EXPECT_NEAR(measure_forces(contact(wave), 0, kStep).buzz, expected, kEnds * (hz > 100 ? expected : 0.1)) << hz;
  }
}

TEST(Buzz, LooksAtSteadyContactOnly) {
  auto frames = contact(std::vector<double>(1000, 0.0));
  for (int i = 0; i < 300; ++i) frames[i].force.x() = i % 2 ? 5 : -5;  // while pressing
  EXPECT_GT(measure_forces(frames, 0, kStep).buzz, 0.5);
  EXPECT_LT(measure_forces(frames, 0.3, kStep).buzz, 1e-12);
  auto refreshed = contact(std::vector<double>(1000, 0.0));
  for (int i = 500; i < 1000; ++i) refreshed[i].model_frame = 1;
  for (int i = 500; i < 505; ++i) refreshed[i].force.x() = 5;  // the bump of a refresh
  EXPECT_LT(measure_forces(refreshed, 0, kStep).buzz, 1e-12);
}

TEST(Buzz, CountsTheBumpsOfRefreshesThatComeOften) {
  for (const int every : {8, 33}) {
    auto frames = contact(std::vector<double>(1000, 0.0));
    for (int i = 0; i < 1000; ++i) {
      frames[i].model_frame = i / every;
      if (i > 0 && i % every == 0) frames[i].force.x() = 0.4;
    }
    const double buzz = measure_forces(frames, 0, kStep).buzz;
    if (every == 8) {
      EXPECT_GT(buzz, 0.03);  // 0.4 / sqrt(8) / 2 without the filter
    } else {
      EXPECT_LT(buzz, 1e-12);
    }
  }
}

TEST(Jumps, AreTheLargestChangeAtACrossingAndAtARefreshOverTheMean) {
  auto frames = contact(std::vector<double>(1000, 0.0));  // |F| = 2
  for (int i = 400; i < 1000; ++i) frames[i].triangle = frames[i].facet = 7;
  for (int i = 700; i < 1000; ++i) frames[i].model_frame = 3;
  frames[200].force.z() = 9;  // neither
  frames[400].force.z() = 2.5;
  frames[700].force.z() = 1;
  const ForceMetrics m = measure_forces(frames, 0, kStep);
  EXPECT_EQ(m.crossings, 1);
  EXPECT_NEAR(m.crossing_jump, 0.5 / 2, 5e-3 * 0.25);
  EXPECT_NEAR(m.refresh_jump, 1.0 / 2, 5e-3 * 0.5);
  EXPECT_EQ(measure_forces(frames, 0.5, kStep).crossing_jump, 0) << "before the steady phase";
}

/// One impulse, of 0.4 N ms, at a crossing: in a tick at 1 kHz, in eight at 8 kHz, or all of it in one of them. And a
/// step that stays.
TEST(Jumps, AreOverAMillisecondWhateverTheRate) {
  const auto jump = [](int rate, int ticks_of_impulse, double after) {
    std::vector<LocalFrame> frames(static_cast<std::size_t>(rate));
    for (int i = 0; i < rate; ++i) {
      LocalFrame& f = frames[static_cast<std::size_t>(i)];
      f.t = (i + 1.0) / rate;
      f.mode = ContactMode::stick;
      f.force = {0, 0, 2};
      f.facet = i < rate / 2 ? 1 : 2;
      const int since = i - rate / 2;
      if (since >= 0) f.force.z() += after;
      if (since >= 0 && since < ticks_of_impulse) f.force.z() += 4e-4 * rate / ticks_of_impulse;
    }
    const ForceMetrics m = measure_forces(frames, 0, 1.0 / rate);
    double mean = 0;
    for (const LocalFrame& f : frames) mean += f.force.z() / rate;
    return m.crossing_jump * mean;
  };
  EXPECT_NEAR(jump(1000, 1, 0), 0.4, 1e-9);
  EXPECT_NEAR(jump(8000, 1, 0), 0.4, 1e-9) << "3.2 N for an eighth of a millisecond";
  EXPECT_NEAR(jump(8000, 8, 0), 0.4, 1e-9);
  EXPECT_NEAR(jump(8000, 0, 0.5), 0.5, 1e-9);
  EXPECT_NEAR(jump(250, 1, 0), 0.1, 1e-9) << "a tick is four milliseconds";
}

TEST(ForceMetrics, CountsModesMeansAndLostContacts) {
  auto frames = contact({3, -1, 0, 0, 0, 0});
  frames[2].mode = ContactMode::stick;
  frames[3].mode = ContactMode::slide;
  frames[4].mode = ContactMode::free;
  frames[4].force.setZero();
  const ForceMetrics m = measure_forces(frames, 0, kStep);
  EXPECT_EQ(m.ticks_free, 1);
  EXPECT_EQ(m.ticks_stick, 1);
  EXPECT_EQ(m.ticks_slide, 1);
  EXPECT_EQ(m.ticks_frictional_slide, 3);
  EXPECT_DOUBLE_EQ(m.mean_n, 2);
  EXPECT_DOUBLE_EQ(m.mean_t, 4.0 / 5);
  EXPECT_EQ(m.max_t, 3);
  EXPECT_EQ(m.max_t_over_n, 1.5);
  EXPECT_EQ(m.lost_contacts, 0) << "the tool did not come nearer";
}

TEST(FeltCone, IsThatOfTheWrittenForceAboutTheNormal) {
  auto frames = contact(std::vector<double>(100, 0.5));  // 0.5 N sideways, 2 N up
  for (LocalFrame& f : frames) f.contacts = 1;
  EXPECT_DOUBLE_EQ(measure_forces(frames, 0, kStep).felt_t_over_n, 0.25);
  frames[50].force = {3, 0, 1.5};  // as a fade leaves it; the contact's own parts stay
  EXPECT_DOUBLE_EQ(measure_forces(frames, 0, kStep).felt_t_over_n, 2);
  EXPECT_DOUBLE_EQ(measure_forces(frames, 0, kStep).max_t_over_n, 0.25);
  frames[50].contacts = 2;  // about which normal?
  frames[60].force = {0.05, 0, 0};
  EXPECT_DOUBLE_EQ(measure_forces(frames, 0, kStep).felt_t_over_n, 0.25) << "too weak to be felt";
  frames[70].force = {0, 0, -1};
  EXPECT_DOUBLE_EQ(measure_forces(frames, 0, kStep).felt_t_over_n, 100) << "it pulls";
}

TEST(LostContacts, AreThoseThatEndWhileTheToolPresses) {
  auto frames = contact({0, 0, 0});
  frames[2].mode = ContactMode::free;
  frames[2].pose.x = {1, 0, 1e-4};
  EXPECT_EQ(measure_forces(frames, 0, kStep).lost_contacts, 0) << "it moved away";
  frames[2].pose.x = {1, 0, -1e-4};
  EXPECT_EQ(measure_forces(frames, 0, kStep).lost_contacts, 1);
}

TEST(Energy, IsTheLowestWorkOfTheToolOnTheBody) {
  auto frames = contact(std::vector<double>(5, 0.0));  // 2 N up on the tool
  const double z[] = {0, -0.1, -0.2, 0.2, 0.1};        // down: the tool works; up: the body does
  for (int i = 0; i < 5; ++i) frames[i].pose.x.z() = z[i];
  EXPECT_NEAR(measure_forces(frames, 0, kStep).energy_min, 2 * 0.2 - 2 * 0.4, 1e-15);
  EXPECT_EQ(measure_forces(std::span(frames).first(3), 0, kStep).energy_min, 0);
}

TEST(Percentile, IsTheNearestRank) {
  const std::vector<double> v{5, 1, 4, 2, 3};
  EXPECT_EQ(percentile(v, 0), 1);
  EXPECT_EQ(percentile(v, 0.2), 1);
  EXPECT_EQ(percentile(v, 0.21), 2);
  EXPECT_EQ(percentile(v, 0.5), 3);
  EXPECT_EQ(percentile(v, 1), 5);
  EXPECT_EQ(percentile({}, 0.5), 0);
}

}  // namespace
}  // namespace kt
