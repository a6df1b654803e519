// Known failures of a hand on a virtual wall: where the limit cycle begins, that it is announced, and what passivity
// control gains.
#include <gtest/gtest.h>

#include "haptics/predict/predict_hand.hpp"
#include "haptics/safety/device_coupling.hpp"
#include "haptics/safety/measured_delay.hpp"
#include "lab/stability/runs/wall_loop.hpp"

namespace kt {
namespace {

MapVerdict verdict_of(const HandLoop& loop, double most_damping = 0) {
  std::string why;
  return judge_ripple(press_wall(loop, most_damping), why);
}

HandLoop loop_of(double stiffness, double damping, double h = 1e-3, double delay = 0) {
  HandLoop out;
  out.wall_stiffness = stiffness;
  out.hand_damping = damping;
  out.h = h;
  out.delay = delay;
  return out;
}

TEST(HandStability, AWallAboveTwoDampingsPerTickIsALimitCycleAndSaidToBe) {
  const double limit = 2 * 1.0 / 1e-3;  // b = K T / 2
  EXPECT_NE(verdict_of(loop_of(0.8 * limit, 1)), MapVerdict::fails);
  EXPECT_EQ(verdict_of(loop_of(1.2 * limit, 1)), MapVerdict::fails);
  EXPECT_FALSE(predict_limit_cycle(loop_of(0.8 * limit, 1)));
  EXPECT_TRUE(predict_limit_cycle(loop_of(1.2 * limit, 1)));
}

TEST(HandStability, DelayLowersTheLimitFivefold) {
  const double limit = 1.0 / (0.5e-3 + 2e-3);
  EXPECT_NE(verdict_of(loop_of(0.8 * limit, 1, 1e-3, 2e-3)), MapVerdict::fails);
  EXPECT_EQ(verdict_of(loop_of(1.2 * limit, 1, 1e-3, 2e-3)), MapVerdict::fails);
  EXPECT_TRUE(predict_limit_cycle(loop_of(1.2 * limit, 1, 1e-3, 2e-3)));
}

TEST(HandStability, PassivityControlHoldsFiveTimesTheLimit) {
  for (const auto& [h, delay] : {std::pair{1e-3, 0.0}, {4e-3, 0.0}, {1e-3, 2e-3}}) {
    const double limit = 1.0 / (0.5 * h + delay);
    const HandLoop loop = loop_of(5 * limit, 1, h, delay);
    EXPECT_EQ(verdict_of(loop), MapVerdict::fails);
    EXPECT_NE(verdict_of(loop, 20), MapVerdict::fails) << h << ' ' << delay;
    EXPECT_FALSE(predict_limit_cycle(loop, 20));
  }
}

/// A device whose damping nobody knows, and whose delay was measured.
HandPort default_port(double delay) {
  MeasuredDelay measured(1e-3);
  for (int i = 0; i < MeasuredDelay::kEnough; ++i) measured.add(delay);
  HandPort out;
  out.most_damping = 20;
  out.delay = measured.estimate().delay;
  out.coupling = coupling_stiffness(0, 0, 1e-3, out.delay);
  return out;
}

MapVerdict verdict_of(const HandLoop& loop, const HandPort& port) {
  std::string why;
  return judge_ripple(press_wall(loop, port), why);
}

TEST(HandStability, ControlAndCouplingHoldAnyWallOnADeviceThatNobodyKnows) {
  for (const double b : {0.1, 0.3, 3.0})
    for (const double delay : {0.0, 0.8e-3, 3e-3})
      for (const double times : {2.0, 5.0, 20.0, 100.0, 1000.0}) {
        const double limit = b / (0.5e-3 + delay);
        const HandLoop loop = loop_of(times * limit, b, 1e-3, delay);
        EXPECT_NE(verdict_of(loop, default_port(delay)), MapVerdict::fails) << b << ' ' << delay << ' ' << times;
        EXPECT_FALSE(predict_limit_cycle(loop, default_port(delay)));
      }
  const HandLoop five = loop_of(5 * 0.3 / 1.3e-3, 0.3, 1e-3, 0.8e-3);
  EXPECT_EQ(verdict_of(five), MapVerdict::fails);
  EXPECT_TRUE(predict_limit_cycle(five));
}

TEST(HandStability, ADelayThatIsToldTooSmallIsNotHeldAndSaidToBe) {
  HandPort port = default_port(0.8e-3);
  port.delay = 0;
  const HandLoop loop = loop_of(5000, 0.3, 1e-3, 0.8e-3);
  EXPECT_EQ(verdict_of(loop, port), MapVerdict::fails);
  EXPECT_TRUE(predict_limit_cycle(loop, port));
}

TEST(HandStability, TheCouplingIsFeltInSeriesWithTheWall) {
  for (const double wall : {100.0, 1000.0, 10000.0}) {
    const HandLoop loop = loop_of(wall, 1, 1e-3, 0.8e-3);
    const double felt = felt_stiffness(wall, kUnknownStiffness);
    EXPECT_NEAR(press_wall(loop, default_port(0.8e-3)).felt, felt, 0.03 * felt) << wall;
  }
}

TEST(HandStability, EnergyBoundingHoldsAnyWallOfADeviceThatItKnowsAndOfNoOther) {
  const HandLoop loop = loop_of(5000, 0.3, 1e-3, 0.8e-3);
  HandPort port;
  port.bounded_damping = 0.3;
  port.delay = 1e-3;
  EXPECT_NE(verdict_of(loop, port), MapVerdict::fails);
  EXPECT_FALSE(predict_limit_cycle(loop, port));
  port.bounded_damping = 1;
  EXPECT_EQ(verdict_of(loop, port), MapVerdict::fails);
  EXPECT_TRUE(predict_limit_cycle(loop, port));
}

}  // namespace
}  // namespace kt
