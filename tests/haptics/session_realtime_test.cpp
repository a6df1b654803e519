// Against the wall clock: nothing here judges times, which a shared machine cannot promise.
#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

TEST(ThreadLink, RunsForASecondWithFiniteForcesAndFreshModels) {
  Scene scene = small_scene();
  scene.duration = 1;
  scene.link.type = "thread";
  const SessionResult r = Session(scene).run();
  ASSERT_EQ(r.tools[0].frames.size(), 1000u);
  double pressed = 0;
  for (const LocalFrame& f : r.tools[0].frames) {
    ASSERT_TRUE(f.force.allFinite());
    pressed = std::max(pressed, f.f_n);
  }
  EXPECT_GT(pressed, 0.01);
#ifdef __SANITIZE_THREAD__
  constexpr std::size_t kFew = 1;  // the body is ten times slower
#else
  constexpr std::size_t kFew = 3;
#endif
  EXPECT_GT(r.refreshes.size(), kFew);
  for (std::size_t i = 1; i < r.refreshes.size(); ++i) {
    EXPECT_GT(r.refreshes[i].linearized_tick, r.refreshes[i - 1].linearized_tick);
    if (r.refreshes[i].adopted_tick >= 0) {  // -1: overtaken by a newer one
      EXPECT_GE(r.refreshes[i].adopted_tick, r.refreshes[i].linearized_tick);
    }
  }
  ASSERT_EQ(r.snapshots.size(), 1u);
  EXPECT_TRUE(r.snapshots[0].x.allFinite());
}

TEST(ThreadLink, StopFlagEndsBothThreads) {
  Scene scene = small_scene();
  scene.duration = 60;
  scene.link.type = "thread";
  std::atomic<bool> stop{false};
  SessionOptions options;
  options.stop = &stop;
  options.progress = [&](double) { stop = true; };
  const SessionResult r = Session(scene).run(options);
  EXPECT_TRUE(r.stopped);
  EXPECT_LT(r.tools[0].frames.size(), 60000u);
  EXPECT_GT(r.tools[0].frames.size(), 0u);
}

}  // namespace
}  // namespace kt
