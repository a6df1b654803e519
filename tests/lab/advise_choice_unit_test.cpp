// The choice of an advice on made-up rows.
#include <gtest/gtest.h>

#include <cmath>

#include "lab/advise/advise.hpp"

namespace kt {
namespace {

constexpr double kTolerance = 0.05;

Candidate row(double error, double cost, double slow = 0.5, double tick = 0.1) { return {error, cost, slow, tick}; }

TEST(AdviseChoice, TakesTheCheapestWithinTheTolerance) {
  const std::vector<Candidate> rows{row(0.01, 3), row(0.04, 2), row(0.06, 1), row(0.02, 2.5)};
  const Choice c = choose(rows, kTolerance);
  EXPECT_TRUE(c.found());
  EXPECT_EQ(c.index, 1);
}

TEST(AdviseChoice, TheToleranceItselfIsWithin) {
  EXPECT_TRUE(choose(std::vector{row(kTolerance, 1)}, kTolerance).found());
  EXPECT_TRUE(choose(std::vector{row(0.01, 1, 1.0, 1.0)}, kTolerance).found());
}

TEST(AdviseChoice, EqualCostsGoToTheSmallerErrorThenToTheEarlier) {
  EXPECT_EQ(choose(std::vector{row(0.03, 1), row(0.02, 1), row(0.02, 1)}, kTolerance).index, 1);
}

TEST(AdviseChoice, SlowRowsDoNotFitHoweverCheapAndExact) {
  const std::vector<Candidate> rows{row(0.001, 1, 1.2), row(0.001, 1, 0.5, 1.01), row(0.04, 9)};
  EXPECT_EQ(choose(rows, kTolerance).index, 2);
}

TEST(AdviseChoice, WithoutOneThatFitsNamesTheNearestInRealTimeAndItsLimit) {
  const std::vector<Candidate> rows{row(0.2, 1), row(0.15, 2), row(0.01, 5, 1.5), row(0.01, 2, 0.5, 4)};
  const Choice c = choose(rows, kTolerance);
  EXPECT_FALSE(c.found());
  EXPECT_EQ(c.index, 1);
  EXPECT_EQ(c.missed, Limit::error);
  const Choice slow = choose(std::span(rows).subspan(2), kTolerance);
  EXPECT_EQ(slow.index, 0);
  EXPECT_EQ(slow.missed, Limit::slow_load);
}

TEST(AdviseChoice, ARowThatMissesTwoLimitsIsAsFarAsTheWorse) {
  const auto [limit, by] = worst_limit(row(0.1, 1, 1.5, 3), kTolerance);
  EXPECT_EQ(limit, Limit::tick_load);
  EXPECT_DOUBLE_EQ(by, 3);
  EXPECT_EQ(worst_limit(row(0.4, 1, 1.5, 3), kTolerance).first, Limit::error);
}

TEST(AdviseChoice, WhatIsNotKnownIsNotChosen) {
  const Candidate no_cost = row(0, std::nan("")), no_error = row(std::nan(""), 0.1);
  EXPECT_EQ(choose(std::vector{no_cost, no_error, row(0.02, 7)}, kTolerance).index, 2);
  const Choice none = choose(std::vector{no_cost, no_error}, kTolerance);
  EXPECT_EQ(none.index, -1);
  EXPECT_FALSE(none.found());
  EXPECT_FALSE(choose({}, kTolerance).found());
}

TEST(AdviseChoice, ATenthOfASecondIsTheLongestThatARefreshMayTake) {
  AdviceBody body;
  body.error = 0.01;
  body.refresh_ms = 150;
  const Choice c = choose(std::vector{candidate_of(body)}, kTolerance);
  EXPECT_EQ(c.missed, Limit::slow_load);
  EXPECT_DOUBLE_EQ(candidate_of(body).slow_load, 1.5);
}

TEST(AdviseChoice, BothPartsOfARefreshMustFitIntoItsInterval) {
  AdviceRow slow;
  slow.rate_hz = 30;
  slow.error = 0.01;
  slow.global_ms = slow.refresh_ms = 20;
  slow.core_share = 1;
  EXPECT_NEAR(candidate_of(slow, 1000).slow_load, 1.2, 1e-12);
  AdviceRow early = slow;
  early.refreshes_per_second = 50;
  EXPECT_NEAR(candidate_of(early, 1000).slow_load, 2, 1e-12);
  AdviceRow tick = slow;
  tick.tick_us = 500;
  EXPECT_NEAR(candidate_of(tick, 4000).tick_load, 2, 1e-12);
}

}  // namespace
}  // namespace kt
