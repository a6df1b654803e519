// Bisection along a ray, rays on threads, and predicted against observed.
#include "lab/stability/bisect.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "lab/stability/map_files.hpp"
#include "lab/stability/maps.hpp"
#include "lab/stability/runs/rays.hpp"

namespace kt {
namespace {

TEST(Bisect, FindsTheBoundaryToItsToleranceFromEitherSide) {
  const auto up = bisect(1e-6, 1.0, {.tolerance = 0.005}, [](double t) { return t > 0.0123; });
  EXPECT_NEAR(up.at() / 0.0123, 1, 0.005);
  EXPECT_LE(up.inside, 0.0123);
  EXPECT_GT(up.outside, 0.0123);
  const auto down = bisect(1.0, 1e-6, {.tolerance = 0.005}, [](double t) { return t < 0.0123; });
  EXPECT_NEAR(down.at() / 0.0123, 1, 0.005);
  const auto linear = bisect(0.9, -0.9, {.tolerance = 0.02, .geometric = false}, [](double t) { return t < -0.1; });
  EXPECT_NEAR(linear.at(), -0.1, 0.02);
}

TEST(Bisect, SaysWhenARayHasNoBoundary) {
  int calls = 0;
  const auto count = [&](bool answer) { return [&calls, answer](double) { return ++calls, answer; }; };
  const RayCrossing inside = bisect(1.0, 2.0, {}, count(false)), outside = bisect(1.0, 2.0, {}, count(true));
  EXPECT_FALSE(inside.is_found());
  EXPECT_EQ(inside.inside, 2);
  EXPECT_FALSE(outside.is_found());
  EXPECT_EQ(outside.outside, 1);
  EXPECT_TRUE(std::isnan(inside.at()) && std::isnan(outside.at()));
  EXPECT_EQ(calls, 3);  // the ends only
}

RayResult ray_of(int i) {
  MapPoint p;
  p.x = i;
  return {{p}, {{"s", "line", {{i, 2 * i}}, false}}};
}

TEST(Rays, AreJoinedInTheirOrderOnAnyNumberOfThreads) {
  for (int jobs : {1, 2, 7}) {
    StabilityMap map;
    run_rays({.jobs = jobs}, 20, ray_of, map);
    ASSERT_EQ(map.points.size(), 20u);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(map.points[static_cast<std::size_t>(i)].x, i);
    ASSERT_EQ(map.boundaries.size(), 1u);
    EXPECT_EQ(map.boundaries[0].points[7], std::make_pair(7.0, 14.0));
  }
}

TEST(Rays, KeepWhatIsThereWhenStoppedAndThrowWhatOneThrows) {
  std::atomic<bool> stop{false};
  StabilityMap map;
  run_rays(
      {.stop = &stop, .jobs = 1}, 20, [&](int i) { return stop = i == 4, ray_of(i); }, map);
  EXPECT_EQ(map.points.size(), 5u);
  EXPECT_THROW(run_rays(
                   {}, 5, [](int i) -> RayResult { throw RunError(text("ray ", i)); }, map),
               RunError);
}

MapPoint judged(MapVerdict verdict, bool predicted) {
  MapPoint p;
  p.verdict = verdict;
  p.predicted_failure = predicted;
  return p;
}

TEST(Confusion, CountsFailuresThatWerePredictedAndAlarmsOverNothing) {
  const Confusion c = count_predictions({judged(MapVerdict::fails, true), judged(MapVerdict::fails, true),
                                         judged(MapVerdict::fails, false), judged(MapVerdict::works, true),
                                         judged(MapVerdict::works, false), judged(MapVerdict::degrades, true)});
  EXPECT_EQ(c, (Confusion{.points = 6,
                          .failures = 3,
                          .predicted = 2,
                          .degraded = 1,
                          .degraded_warned = 1,
                          .working = 2,
                          .false_alarms = 1}));
  EXPECT_EQ(c.alarms(), 4);
}

TEST(MapFiles, QuoteWordsAndKeepNumbersToTheLastBit) {
  StabilityMap map;
  MapPoint p = judged(MapVerdict::fails, true);
  p.series = "a, \"b\"";
  p.x = 0.1;
  p.y = 1e-300;
  p.hash = 255;
  map.points = {p};
  const std::string csv = points_csv(map);
  EXPECT_NE(csv.find("\"a, \"\"b\"\"\",0.1,1e-300,fails,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("00000000000000ff\n"), std::string::npos) << csv;
}

TEST(Maps, UnknownNamesAreRefusedWithTheKnownOnes) {
  EXPECT_EQ(find_maps({}).size(), stability_maps().size());
  EXPECT_EQ(find_maps({"poisson", "time_step"}).front().name, "time_step");  // the table's order
  try {
    find_maps({"time_stap"});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean \"time_step\""), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("poisson"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace kt
