// A hand that presses an organ and holds still comes to rest, however late the body's models come.
#include <gtest/gtest.h>

#include "haptics/session/session.hpp"

namespace kt {
namespace {

/// 200 ms each way. A body that was linearized where the hand would be, were it to swing on, made it swing on:
/// by 0.6 mm here.
TEST(HeldHand, ComesToRestOverALinkWithDelay) {
  if (!KT_WITH_TETGEN) GTEST_SKIP() << "needs tetgen";
  constexpr double kStill = 5e-5;          // [m]: nobody feels less
  constexpr std::size_t kLastTicks = 250;  // two swings of such a hand
  Scene scene = load_scene(KT_SOURCE_DIR "/scenes/organ_springs.json",
                           {"local.reducer=condensed", "link.latency_ms=400", "duration=0.31"});
  const Vec3 pressed = Session(scene).path().back().x;
  scene.duration = 2.2;
  scene.tool.path.press_drag.reset();
  const Vec3 up = Vec3::UnitZ();
  scene.tool.path.hand = SceneHand{.damping = 0.5, .target = {{0, pressed + 4.5e-3 * up}, {0.35, pressed - 1e-3 * up}}};
  const SessionResult run = Session(scene).run();
  const std::span<const LocalFrame> frames = run.tools[0].frames;
  EXPECT_GT(frames.back().f_n, 0.1) << "it holds nothing";
  EXPECT_EQ(run.tools[0].missed_impacts, 0);
  Vec3 low = frames.back().pose.x, high = low;
  for (std::size_t i = frames.size() - kLastTicks; i < frames.size(); ++i) {
    low = low.cwiseMin(frames[i].pose.x);
    high = high.cwiseMax(frames[i].pose.x);
  }
  EXPECT_LT((high - low).maxCoeff(), kStill);
  std::printf("swings by %.1f um, %d vertices\n", 1e6 * (high - low).maxCoeff(), run.last_patch_vertices);
}

}  // namespace
}  // namespace kt
