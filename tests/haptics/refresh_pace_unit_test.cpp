#include "haptics/refresh/refresh_pace.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(RefreshPace, HurriesForAnErrorOfAForceThatIsFelt) {
  RefreshPace pace;
  pace.judge(0.1, 0.2, 0.1, 0.05);
  EXPECT_EQ(pace.haste(), 2);
  pace.judge(0.2, 0.2, 0.1, 0.05);
  EXPECT_EQ(pace.haste(), 4);
}

TEST(RefreshPace, TakesAnErrorOfASmallForceAsOneOfAHundredthOfANewton) {
  RefreshPace pace;
  pace.judge(0.1, 0.08, 0.005, 0.05);
  EXPECT_EQ(pace.haste(), 1);
  pace.judge(0.2, 0.12, 0.005, 0.05);
  EXPECT_EQ(pace.haste(), 2);
}

// When a tool begins to touch, half of a force of half a millinewton is wrong.
TEST(RefreshPace, DoesNotHurryForAForceThatNobodyFeels) {
  RefreshPace pace;
  pace.judge(0.1, 0.5, 0.0005, 0.05);
  EXPECT_EQ(pace.haste(), 1);
  pace.judge(0.2, 0.01, 0.1, 0.05);
  EXPECT_EQ(pace.haste(), 1);
}

TEST(RefreshPace, CalmsDownAQuarterOfASecondAfterTheBodyGaveWay) {
  RefreshPace pace;
  pace.judge(0.1, 0.2, 0.1, 0.05);
  pace.judge(0.2, 0.001, 0.1, 0.05);
  EXPECT_EQ(pace.haste(), 2);
  pace.judge(0.4, 0.001, 0.1, 0.05);
  EXPECT_EQ(pace.haste(), 1);
}

}  // namespace
}  // namespace kt
