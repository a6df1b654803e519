// Loss by chance and loss of a full line, in virtual time: models are spread over a line with a rate, a queue and a
// loss, and the receiver tells what came.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "network/channel/paced_sender.hpp"
#include "network/channel/parity.hpp"
#include "network/channel/rate_control.hpp"

namespace kt {
namespace {

struct LineOptions {
  double rate = 1e9;    ///< datagrams a second
  double queue = 0.1;   ///< [s]; as deep as the bucket of a line that cuts off
  double loss = 0;      ///< by chance
  double delay = 0.01;  ///< [s] each way
  int model = 62;       ///< datagrams, without parity
  double models = 30;   ///< a second
};

struct Came {
  double sent_rate = 0, lost = 0, chance = 0, models = 0;  ///< of the last seconds
  int full = 0;
};

/// Sends models as a body does; figures of the last half.
class VirtualBody {
 public:
  explicit VirtualBody(const LineOptions& line) : line_(line), random_(7) {}

  Came run(double seconds) {
    const double step = 1e-3;
    double next_model = 0;
    for (now_ = 0; now_ < seconds; now_ += step) {
      if (now_ >= next_model && left_ == 0) begin_model();
      if (now_ >= next_model) next_model += 1 / line_.models;
      for (room_ = std::min(room_ + pace_ * step, 8.0); left_ > 0 && room_ >= 1; room_ -= 1) send_one(seconds);
      arrive();
    }
    const double time = seconds / 2;
    return {static_cast<double>(counted_) / time,
            static_cast<double>(lost_) / static_cast<double>(std::max(1L, counted_)),
            control_.chance_loss().value_or(-1), static_cast<double>(models_) / time, control_.num_full()};
  }

 private:
  void begin_model() {
    left_ = line_.model + parity_shards(line_.model, control_.chance_loss().value_or(kLossUntilKnown));
    const Pace pace = pace_for(static_cast<std::size_t>(left_), 0.5 / line_.models, control_.limit());
    pace_ = pace.datagrams / (1e-6 * static_cast<double>(pace.interval.count()));
  }

  void send_one(double seconds) {
    const bool counts = now_ > seconds / 2;
    const std::uint64_t number = sent_++;
    counted_ += counts;
    if (--left_ == 0) models_ += counts;
    const bool is_full = free_at_ > now_ + line_.queue + 1 / line_.rate;
    const bool by_chance = std::uniform_real_distribution<double>(0, 1)(random_) < line_.loss;
    if (!is_full) free_at_ = std::max(free_at_, now_) + 1 / line_.rate;
    lost_ += counts && (is_full || by_chance);
    if (!is_full && !by_chance) on_way_.emplace_back(free_at_ + line_.delay, number);
  }

  void arrive() {
    for (; !on_way_.empty() && on_way_.front().first <= now_; on_way_.pop_front()) {
      feedback_.newest = std::max(feedback_.newest, on_way_.front().second + 1);
      ++feedback_.came;
    }
    told_.emplace_back(now_ + line_.delay, feedback_);
    for (; !told_.empty() && told_.front().first <= now_; told_.pop_front())
      control_.told(told_.front().second, sent_,
                    RateControl::Time(std::chrono::nanoseconds(std::llround(1e9 * (100 + now_)))));
  }

  LineOptions line_;
  std::mt19937_64 random_;
  RateControl control_;
  double now_ = 0, room_ = 0, pace_ = 0, free_at_ = 0;
  int left_ = 0;
  std::uint64_t sent_ = 0;
  long counted_ = 0, lost_ = 0, models_ = 0;
  Feedback feedback_;
  std::deque<std::pair<double, std::uint64_t>> on_way_;
  std::deque<std::pair<double, Feedback>> told_;
};

constexpr double kNeed = 62 * 30;  // datagrams a second of the models without parity: 17.7 Mbit/s

TEST(RateControl, LossByChanceGetsItsParityAndNoLimit) {
  for (const double loss : {0.0, 0.05, 0.2, 0.4}) {
    const Came came = VirtualBody({.loss = loss}).run(20);
    EXPECT_NEAR(came.chance, loss, 0.05) << loss;
    EXPECT_GT(came.models, 27) << loss;
    EXPECT_LE(came.full, loss == 0 ? 0 : 2) << loss;
  }
}

/// The line: 20 Mbit/s, for models of 17.
TEST(RateControl, ALineThatJustFitsIsNotFilledWithParity) {
  for (const double queue : {0.02, 0.05, 0.1, 0.4}) {
    const Came came = VirtualBody({.rate = 2100, .queue = queue}).run(20);
    EXPECT_LT(came.lost, 0.05) << queue;
    EXPECT_LT(came.chance, 0.05) << queue;
    EXPECT_LT(came.sent_rate, 2200) << queue;
    EXPECT_GT(came.models, 20) << queue;
  }
}

TEST(RateControl, OverALineThatIsTooSlowFewerModelsGoWhole) {
  for (const double rate : {1500.0, 800.0, 400.0})
    for (const double queue : {0.02, 0.1}) {
      const Came came = VirtualBody({.rate = rate, .queue = queue}).run(40);
      EXPECT_LT(came.lost, 0.08) << rate << " " << queue;
      EXPECT_LT(came.sent_rate, 1.08 * rate) << rate << " " << queue;
      EXPECT_GT(came.models, 0.5 * rate / 70) << rate << " " << queue;
      EXPECT_GE(came.full, 1);
    }
}

TEST(RateControl, AFullLineThatLosesByChanceTooKeepsParityForThatAlone) {
  const Came came = VirtualBody({.rate = 1500, .loss = 0.1}).run(40);
  EXPECT_NEAR(came.chance, 0.1, 0.05);
  EXPECT_LT(came.lost, 0.2);
  EXPECT_GT(came.models, 8);
}

TEST(RateControl, WhatCannotBeIsIgnored) {
  RateControl control;
  const RateControl::Time now{std::chrono::hours(1)};
  for (int i = 0; i < 50; ++i)
    control.told({static_cast<std::uint64_t>(1) << 60, 3}, 1000, now + std::chrono::milliseconds(100 * i));
  for (int i = 0; i < 50; ++i)
    control.told({static_cast<std::uint64_t>(20 * i), 1000000ul * static_cast<std::uint64_t>(i)}, 1000,
                 now + std::chrono::milliseconds(100 * i));
  EXPECT_TRUE(std::isinf(control.limit()));
  EXPECT_GE(control.chance_loss().value_or(0), 0);
}

TEST(PaceFor, SpreadsAndDoesNotDawdle) {
  const auto rate = [](const Pace& p) { return p.datagrams / (1e-6 * static_cast<double>(p.interval.count())); };
  EXPECT_NEAR(rate(pace_for(62, 1 / 60.0, 1e9)), 62 * 60, 60);
  EXPECT_NEAR(rate(pace_for(2, 1 / 60.0, 1e9)), 1000, 1);
  EXPECT_NEAR(rate(pace_for(62, 1 / 60.0, 500)), 500, 1);
  EXPECT_EQ(pace_for(62, 1 / 60.0, 500).datagrams, 1);
}

}  // namespace
}  // namespace kt
