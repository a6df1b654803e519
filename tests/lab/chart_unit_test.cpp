#include "lab/chart/point.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kt {
namespace {

TEST(ParetoFront, IsWhatNoOtherBeats) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> number(0, 12);  // so few that many are equal
  for (int sample = 0; sample < 2000; ++sample) {
    const auto n = static_cast<std::size_t>(number(random));
    std::vector<double> cost(n), error(n);
    for (std::size_t i = 0; i < n; ++i) {
      cost[i] = number(random);
      error[i] = number(random);
      if (number(random) == 0) error[i] = NAN;
    }
    const std::vector<bool> front = pareto_front(cost, error);
    ASSERT_EQ(front.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      bool is_beaten = !std::isfinite(error[i]);
      for (std::size_t k = 0; k < n; ++k)
        is_beaten |= cost[k] <= cost[i] && error[k] <= error[i] && (cost[k] < cost[i] || error[k] < error[i]);
      EXPECT_EQ(front[i], !is_beaten) << i << " of " << n;
    }
  }
}

TEST(ChartPoint, HasAPlaceForEveryAxis) {
  const nlohmann::ordered_json row = {{"key", "k"},
                                      {"outcome", "done"},
                                      {"trouble", ""},
                                      {"result", {{"step_us", {{"p50", 20}}}, {"truth", {{"force_error", 0.05}}}}}};
  const auto point = chart_point(row);
  EXPECT_EQ(point["tick_p50_us"], 20);
  EXPECT_NEAR(point["force_error"].get<double>(), 5, 1e-12);  // %
  for (const ChartAxis& axis : chart_axes()) EXPECT_TRUE(point.contains(axis.key)) << axis.key;
  EXPECT_TRUE(point["buzz"].is_null());
  const auto failed = chart_point({{"key", "k"}, {"outcome", "crash"}, {"trouble", "crashed"}, {"result", nullptr}});
  EXPECT_EQ(failed["outcome"], "crash");
  EXPECT_TRUE(failed["force_error"].is_null());
}

}  // namespace
}  // namespace kt
