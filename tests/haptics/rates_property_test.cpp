// local.rate_hz from 250 Hz to 10 kHz: the same forces, and what lasts a time lasts as long.
#include <gtest/gtest.h>

#include "core/base/ticks.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

Scene at_rate(double hz) {
  Scene scene = small_scene();
  scene.local.rate_hz = hz;
  return scene;
}

double mean_force(const SessionResult& run) {
  double sum = 0;
  for (const LocalFrame& f : run.tools[0].frames) sum += f.force.norm();
  return sum / static_cast<double>(run.tools[0].frames.size());
}

TEST(Rates, GiveTheSameForce) {
  const double usual = mean_force(Session(at_rate(1000)).run());
  ASSERT_GT(usual, 0.01);
  for (const double hz : {250.0, 4000.0, 8000.0}) {
    const SessionResult run = Session(at_rate(hz)).run();
    EXPECT_NEAR(mean_force(run), usual, 0.01 * usual) << hz << " Hz";
    EXPECT_EQ(run.tools[0].missed_impacts, 0) << hz << " Hz";
  }
}

TEST(Rates, OutsideOfWhatIsSensibleAreToldInOneLine) {
  const auto told = [](double hz) {
    int count = 0;
    const Session session(at_rate(hz));
    for (const std::string& w : lines(session.findings())) count += w.find("local.rate_hz is ") == 0;
    return count;
  };
  for (const double hz : {250.0, 1000.0, 10000.0}) EXPECT_EQ(told(hz), 0) << hz;
  for (const double hz : {100.0, 20000.0}) EXPECT_EQ(told(hz), 1) << hz;
}

TEST(Rates, LeaveATickNoMoreThanItsPeriod) {
  TouchOptions options;
  for (const auto& [hz, us] : {std::pair{250.0, 200.0}, {1000.0, 200.0}, {4000.0, 200.0}, {8000.0, 100.0}}) {
    options.local.rate_hz = hz;
    EXPECT_DOUBLE_EQ(tick_budget_us(options), us) << hz;
  }
  options.local.budget_us = 30;
  EXPECT_DOUBLE_EQ(tick_budget_us(options), 30);
}

TEST(Ticks, OfATimeAreRoundedAndBounded) {
  EXPECT_EQ(ticks_in(0.016, 1000), 16);
  EXPECT_EQ(ticks_in(0.016, 8000), 128);
  EXPECT_EQ(ticks_in(0.0001, 1000), 1);
  EXPECT_EQ(ticks_in(4.096, 250, 4096), 4096);
  EXPECT_EQ(ticks_in(1, 1e6, 1, 5000), 5000);
  EXPECT_EQ(ticks_in(1e9, 1e6), 1 << 30);
}

}  // namespace
}  // namespace kt
