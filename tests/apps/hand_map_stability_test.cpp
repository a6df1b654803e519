// Known failures of a hand on a virtual wall: where the limit cycle begins, that it is announced, and what passivity
// control gains.
#include <gtest/gtest.h>

#include "apps/stability/wall_loop.hpp"
#include "haptics/predict/predict_hand.hpp"

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

}  // namespace
}  // namespace kt
