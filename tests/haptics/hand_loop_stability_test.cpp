// Where a sampled loop of hand and wall loses its stability, against the closed form of Colgate and Schenkel (1997)
// with the delay of Diolaiti et al. (2006).
#include <gtest/gtest.h>

#include "haptics/device/hand_loop.hpp"
#include "haptics/predict/predict_hand.hpp"

namespace kt {
namespace {

TEST(HandLoop, ItsLimitIsDampingOverHalfATickAndTheDelay) {
  for (double h : {0.25e-3, 1e-3, 4e-3})
    for (double delay : {0.0, 0.7 * h, 2 * h, 5e-3})
      for (double damping : {0.1, 0.5, 2.0}) {
        HandLoop loop;
        loop.h = h;
        loop.delay = delay;
        loop.hand_damping = damping;
        const double passive = damping / (0.5 * h + delay);
        const double ratio = stiffest_stable_wall(loop) / passive;
        EXPECT_GT(ratio, 0.99) << "what is passive is stable: " << h << ' ' << delay << ' ' << damping;
        EXPECT_LT(ratio, 1.1) << h << ' ' << delay << ' ' << damping;
        loop.wall_stiffness = passive;
        EXPECT_NEAR(passive_damping(loop), damping, 1e-12);
      }
}

TEST(HandLoop, GrowsAboveItsLimitAndRestsBelow) {
  HandLoop loop;
  loop.hand_damping = 1;
  const double limit = stiffest_stable_wall(loop);
  loop.wall_stiffness = 0.99 * limit;
  EXPECT_LT(loop_growth(loop), 1);
  loop.wall_stiffness = 1.01 * limit;
  EXPECT_GT(loop_growth(loop), 1);
}

TEST(PredictLimitCycle, NamesTheLimitAndWhatToChange) {
  HandLoop loop;
  loop.hand_damping = 1;
  loop.wall_stiffness = 1000;
  EXPECT_FALSE(predict_limit_cycle(loop));
  loop.wall_stiffness = 3000;
  const auto found = predict_limit_cycle(loop);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->failure, "hand");
  for (const char* words : {"3000 N/m", "limit cycle", "tool.path.hand.damping", "local.passivity_damping"})
    EXPECT_NE(found->message().find(words), std::string::npos) << found->message();
  EXPECT_FALSE(predict_limit_cycle(loop, 20)) << "passivity control holds it";
  loop.wall_stiffness = 50000;
  EXPECT_TRUE(predict_limit_cycle(loop, 20));
}

}  // namespace
}  // namespace kt
