#include "haptics/session/real_time.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

/// A second in which everything is quick: 30 refreshes of 4 ms, ticks of 20 us.
SessionResult quick_run() {
  SessionResult r;
  r.tools[0].frames.resize(1000, LocalFrame());
  r.step_us.resize(1000, 20);
  r.refresh.global_ms.assign(30, 1);
  r.refresh.refresh_ms.assign(30, 3);
  r.refresh.parts_ms = {{"linearize", std::vector<double>(30, 0.5)},
                        {"reduce", std::vector<double>(30, 2)},
                        {"certify", std::vector<double>(30, 0.3)},
                        {"prepare", std::vector<double>(30, 0.2)}};
  r.refreshes.resize(30);
  r.reducer = "krylov";
  return r;
}

TEST(RealTime, HoldsWhereBothSidesAreQuick) {
  const RealTime t = judge_real_time(Scene{}, quick_run());
  EXPECT_EQ(t.keeps, Keeps::yes);
  EXPECT_NEAR(t.refresh_ms, 4, 1e-12);
  EXPECT_NEAR(t.refresh_hz, 30, 1e-12);
  EXPECT_NEAR(t.tick_share, 0.02, 1e-12);
  EXPECT_NEAR(t.refresh_share, 0.12, 1e-12);
  EXPECT_NEAR(t.budget_ms, 1e3 / 30, 1e-12);
  EXPECT_TRUE(t.cures.empty());
}

TEST(RealTime, NamesTheReductionWhereThatIsSlowAndNotTheStep) {
  SessionResult r = quick_run();
  r.refresh.refresh_ms.assign(30, 60);
  r.refresh.parts_ms[1].second.assign(30, 55);
  const RealTime t = judge_real_time(Scene{}, r);
  EXPECT_EQ(t.keeps, Keeps::no);
  EXPECT_EQ(t.slow_part, "reduce");
  EXPECT_NE(t.told().find("no: a refresh takes 61 ms of 33.3, 183 % (reduce 55)"), std::string::npos) << t.told();
  EXPECT_NE(t.cure().find("local.reducer to condensed"), std::string::npos) << t.cure();
  EXPECT_NE(t.cure().find("global.rate_hz to 13"), std::string::npos) << t.cure();
}

TEST(RealTime, NamesTheGlobalStepWhereThatIsSlow) {
  SessionResult r = quick_run();
  r.refresh.global_ms.assign(30, 40);
  const RealTime t = judge_real_time(Scene{}, r);
  EXPECT_EQ(t.keeps, Keeps::no);
  EXPECT_EQ(t.slow_part, "global step");
}

TEST(RealTime, NamesTheTickWhereThatIsSlower) {
  SessionResult r = quick_run();
  r.step_us = {};
  r.step_us.resize(1000, 1500);
  const RealTime t = judge_real_time(Scene{}, r);
  EXPECT_EQ(t.keeps, Keeps::no);
  EXPECT_EQ(t.slow_part, "haptic tick");
  EXPECT_NE(t.cure().find("local.reducer to condensed"), std::string::npos) << t.cure();
}

TEST(RealTime, IsJustAboutKeptWithLittleRoomOrWithEarlyRefreshesThatDoNotFit) {
  SessionResult r = quick_run();
  r.refresh.refresh_ms.assign(30, 29);
  EXPECT_EQ(judge_real_time(Scene{}, r).keeps, Keeps::just_about);
  SessionResult early = quick_run();
  early.refresh.refresh_ms.assign(98, 12);
  early.refreshes.resize(98);
  EXPECT_EQ(judge_real_time(Scene{}, early).keeps, Keeps::just_about);
}

/// The first refresh sets the run up.
TEST(RealTime, DoesNotCountTheFirstRefresh) {
  SessionResult r = quick_run();
  r.refresh.global_ms.assign(2, 1);
  r.refresh.refresh_ms = {5000, 3};
  EXPECT_NEAR(judge_real_time(Scene{}, r).refresh_ms, 4, 1e-12);
}

/// Another program had the processor nine tenths of the time.
TEST(RealTime, TakesTheProcessorsTimeWhereThatIsLess) {
  SessionResult r = quick_run();
  r.refresh.refresh_ms.assign(30, 39);
  r.refresh.cpu_ms.assign(30, 4);
  EXPECT_NEAR(judge_real_time(Scene{}, r).refresh_ms, 4, 1e-12);
  r.refresh.cpu_ms.assign(30, 80);  // of two threads
  EXPECT_NEAR(judge_real_time(Scene{}, r).refresh_ms, 40, 1e-12);
}

/// Each refresh takes time in a lockstep that charges it: what does not fit is left out.
TEST(RealTime, OfAChargedLockstepIsWhatWasReached) {
  SessionResult r = quick_run();
  r.refreshes.resize(12);
  EXPECT_EQ(judge_real_time(Scene{}, r).keeps, Keeps::yes);
  Scene charged;
  charged.link.charge_refreshes = "measured";
  EXPECT_EQ(judge_real_time(charged, r).keeps, Keeps::no);
}

/// Twenty-six of thirty are not "just about": the figures are of thirty.
TEST(RealTime, OfAThreadedRunIsWhatWasReached) {
  SessionResult r = quick_run();
  r.lateness_us.resize(1000, 5);
  const auto keeps = [&](std::size_t refreshes) {
    r.refreshes.resize(refreshes);
    return judge_real_time(Scene{}, r).keeps;
  };
  EXPECT_EQ(keeps(12), Keeps::no);
  EXPECT_EQ(keeps(26), Keeps::no);
  EXPECT_EQ(keeps(28), Keeps::no);
  EXPECT_EQ(keeps(29), Keeps::yes);
  EXPECT_EQ(keeps(30), Keeps::yes);
  keeps(26);
  const RealTime t = judge_real_time(Scene{}, r);
  EXPECT_TRUE(t.lags);
  EXPECT_NE(t.cure().find("set global.rate_hz to 26 "), std::string::npos) << t.cure();
  keeps(28);
  EXPECT_NE(judge_real_time(Scene{}, r).cure().find("set global.rate_hz to 27 "), std::string::npos);
  EXPECT_EQ(t.told().rfind("no: 26 of 30 refreshes a second, a refresh takes 4 ms", 0), 0u) << t.told();
}

/// What takes an eighth of its time is not why refreshes are missing.
TEST(RealTime, DoesNotBlameABodyThatIsQuick) {
  SessionResult r = quick_run();
  r.lateness_us.resize(1000, 5);
  r.refreshes.resize(12);
  const RealTime t = judge_real_time(Scene{}, r);
  EXPECT_TRUE(t.is_crowded);
  EXPECT_NE(t.told().find("other programs hold the processor"), std::string::npos) << t.told();
  EXPECT_EQ(t.cure().rfind("close what runs beside it", 0), 0u) << t.cure();
  EXPECT_EQ(t.cure().find("local.reducer"), std::string::npos) << t.cure();
  EXPECT_EQ(t.cure().find("coarser"), std::string::npos) << t.cure();
  r.refresh.refresh_ms.assign(30, 60);
  EXPECT_FALSE(judge_real_time(Scene{}, r).is_crowded);
}

/// "set local.reducer to wall (31 % or more)" took a tube from 16 to 972 %: no reducer that is known to be off is told.
TEST(RealTime, TellsNoReducerWhoseForceIsOff) {
  SessionResult r = quick_run();
  r.reducer = "condensed";
  r.refresh.refresh_ms.assign(30, 60);
  r.refresh.parts_ms[1].second.assign(30, 55);
  const auto cure = [&](double error) {
    r.reducer_candidates.assign(1, {});
    r.reducer_candidates[0].reducer = "wall";
    r.reducer_candidates[0].force_error = error;
    return judge_real_time(Scene{}, r).cure();
  };
  EXPECT_NE(cure(0.08).find("set local.reducer to wall (force of the local model off by 8 % or more)"),
            std::string::npos)
      << cure(0.08);
  EXPECT_EQ(cure(0.16).find("local.reducer"), std::string::npos) << cure(0.16);
  EXPECT_EQ(cure(std::numeric_limits<double>::quiet_NaN()).find("local.reducer"), std::string::npos);
}

/// The first local model set the body up; the others did not get here: no mesh is to blame.
TEST(RealTime, OfALinkThatLetsNothingThroughBlamesTheLink) {
  SessionResult r = quick_run();
  r.tools[0].frames.resize(4000, LocalFrame());
  r.lateness_us.resize(4000, 5);
  r.refreshes.resize(1);
  r.refresh.global_ms.clear();
  r.refresh.refresh_ms.assign(1, 2070);
  Scene scene;
  scene.link.type = "network";
  const RealTime t = judge_real_time(scene, r);
  EXPECT_EQ(t.keeps, Keeps::no);
  EXPECT_EQ(t.slow_part, "link");
  EXPECT_EQ(t.told().rfind("no: 0.25 of 30 refreshes a second came over the link", 0), 0u) << t.told();
  EXPECT_EQ(t.told().find("coarser"), std::string::npos) << t.told();
}

/// A body that is as coarse as its contact bears is not to be made coarser, nor of tet4 where tet10 are the cure.
TEST(RealTime, AsksForNothingThatTheContactCannotBear) {
  SessionResult r = quick_run();
  r.reducer = "condensed";
  r.refresh.global_ms.assign(30, 900);
  Scene scene;
  scene.object.mesh = "organ.off";
  scene.object.model.type = "fem";
  scene.object.model.element = "tet10";
  EXPECT_NE(judge_real_time(scene, r).cure().find("object.model.element to tet4"), std::string::npos);
  EXPECT_NE(judge_real_time(scene, r).cure().find("take a coarser mesh"), std::string::npos);
  const std::string cure = judge_real_time(scene, r, {.coarser = false, .linear_elements = false}).cure();
  EXPECT_EQ(cure.find("tet4"), std::string::npos) << cure;
  EXPECT_NE(cure.find("as coarse as the contact bears"), std::string::npos) << cure;
  scene.tool.shape = "mesh";
  const std::string tool = judge_real_time(scene, r, {.tool_triangles = {20000}}).cure();
  EXPECT_EQ(tool.rfind("take fewer triangles in tool.mesh (20000 now", 0), 0u) << tool;
}

}  // namespace
}  // namespace kt
