// The tick's friction against textbook problems with closed forms. The long version is bench/friction_table.
#include <gtest/gtest.h>

#include "bench/friction_rig.hpp"

namespace kt {
namespace {

TEST(StickSlipOscillator, HasThePeriodAndTheSwingOfTheClosedFormAtEveryStep) {
  constexpr double kShare = 0.01, kRoundoff = 1e-14;  // [m]
  const StickSlip rig;
  const StickSlipMotion exact = closed_form(rig);
  const double swing = exact.highest - exact.lowest;
  for (const double h : {1e-4, 5e-4, 1e-3, 2e-3}) {
    const StickSlipMotion m = measure(rig, h, 4);
    EXPECT_NEAR(m.period, exact.period, kShare * exact.period) << h;
    EXPECT_NEAR(m.lowest, exact.lowest, kShare * swing) << h;
    EXPECT_NEAR(m.highest, exact.highest, kShare * swing) << h;
    EXPECT_LE(m.stick_slip_apart, kRoundoff) << h;
  }
}

TEST(StickSlipOscillator, SticksExactlyWhateverTheScheme) {
  StickSlip rig;
  rig.block.scheme = LocalScheme::implicit_euler;
  for (const double h : {5e-4, 2e-3}) EXPECT_LE(measure(rig, h, 2).stick_slip_apart, 1e-14);
}

TEST(Creep, ThereIsNoneJustInsideTheCone) {
  for (const double h : {5e-4, 1e-3, 2e-3}) {
    EXPECT_LT(creep(0.99, h, 3), 1e-12) << h;
    EXPECT_GT(creep(1.01, h, 3), 1e-4) << h;
  }
}

TEST(Slope, SlidesFromTheAngleOfFrictionOn) { EXPECT_NEAR(critical_slope_error(0.5, 1e-3), 0, 1e-4); }

TEST(SlidingTool, StopsWhereItsEnergyIsSpent) {
  constexpr double kStep = 1e-3, kShare = 0.005;
  const Stop stop = slide_to_rest(1, 0.3, kStep);
  EXPECT_NEAR(stop.distance, stop.closed_form, kShare * stop.closed_form);
  EXPECT_NEAR(stop.friction_work, stop.lost, kShare * stop.lost);
}

TEST(RollingBall, GoesFiveSeventhsAsFastAsOneThatSlides) { EXPECT_NEAR(rolling_error(0.3, 0.5, 1e-3), 0, 0.005); }

}  // namespace
}  // namespace kt
