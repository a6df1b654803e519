// A local model that came very late, as on a machine that is too busy, and the replay of such a run.
#include <gtest/gtest.h>

#include "haptics/halves/body_side.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// At which tick a model of tick 0 stands after it was caught up with, `late` ticks later.
int caught_up_at(const TouchOptions& options, const Session& session, int late) {
  BodySide body(session.body(), options);
  HapticSide side(options, SurfaceFriction{});
  const Pose pose{Vec3(0, 0, 0.1), Quaternion::Identity()};
  side.place({&pose, 1});
  const auto model = [&] { return body.refresh({0, 0}, {&pose, 1}, {}, nullptr, [] { return 0.0; }); };
  auto coming = model();
  LocalFrame frame;
  for (int i = 0; i < late; ++i) side.tick({&pose, 1}, {&frame, 1});
  int at = 0;
  side.catch_up(coming, at, late);
  return at;
}

/// The thread catches up from its reports, for which there is no limit: seen once with a model of 7472 ticks before,
/// whose replay took it as it was.
TEST(LateModel, OfAReplayIsCaughtUpWithHoweverLateItWas) {
  const Session session(small_scene());
  TouchOptions options = session.options();
  EXPECT_EQ(caught_up_at(options, session, 4000), 4000);
  EXPECT_EQ(caught_up_at(options, session, 6000), 0) << "without a replay: too old, taken as it is";
  options.replay.refreshes = {{0, 0, 0}, {10, 6010, 10}};
  EXPECT_EQ(caught_up_at(options, session, 6000), 6000);
}

}  // namespace
}  // namespace kt
