// Refreshes come sooner where the body bends away from its local models, and go on so for a while.
#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/session/session.hpp"

namespace kt {
namespace {

/// Springs without guards of their volumes, which buckle.
SessionResult dragged(double rate_hz) {
  Scene scene;
  scene.duration = 0.6;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/block.msh";
  scene.object.model.type = "msd";
  scene.object.model.least_volume = 0;
  scene.object.fixed.below->fraction = 0.05;
  scene.local.reducer = "condensed";
  scene.global.rate_hz = rate_hz;
  scene.tool.shape = "point";
  scene.tool.path.press_drag =
      PressDrag{.at = {}, .depth = 0.004, .press_time = 0.1, .direction = {1, 0, 0}, .speed = 0.05};
  Session session(scene);
  return session.run();
}

/// From refresh i to the next [ticks].
int interval(const SessionResult& run, std::size_t i) {
  return run.refreshes[i + 1].linearized_tick - run.refreshes[i].linearized_tick;
}

TEST(EarlyRefresh, IsNeverSoonerThanAModelNeedsToFindItsBalance) {
  const SessionResult run = dragged(60);
  int shortest = 100;
  for (std::size_t i = 0; i + 1 < run.refreshes.size(); ++i) shortest = std::min(shortest, interval(run, i));
  EXPECT_EQ(shortest, 8);
}

TEST(EarlyRefresh, GoesOnForAWhileWhereTheBodyGaveWay) {
  const SessionResult run = dragged(30);
  int seen = 0;
  for (std::size_t i = 0; i < run.refresh.linearization_error.size(); ++i) {
    const RefreshEvent& gave_way = run.refreshes[i + 1];
    if (run.refresh.linearization_error[i] < 0.3 || gave_way.linearized_tick < 100) continue;
    for (std::size_t k = i + 1;
         k + 1 < run.refreshes.size() && run.refreshes[k].linearized_tick < gave_way.linearized_tick + 250; ++k) {
      EXPECT_LE(interval(run, k), interval(run, k - 1))
          << "at tick " << run.refreshes[k].linearized_tick << ", after " << gave_way.linearized_tick;
      seen += run.refresh.linearization_error[k] < 0.02;
    }
  }
  EXPECT_GT(seen, 0) << "nothing tempted it to stop";
}

}  // namespace
}  // namespace kt
