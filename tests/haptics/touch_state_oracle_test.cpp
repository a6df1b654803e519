// A touch that goes on from a copied state, against the run that went on.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "core/base/error.hpp"
#include "core/body/state.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "tests/support/frames.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// Frames of a touch along these poses.
std::vector<LocalFrame> frames_of(Touch& touch, std::span<const LocalFrame> way) {
  std::vector<LocalFrame> out;
  for (const LocalFrame& f : way) out.push_back(touch.tick(f.pose));
  return out;
}

/// In the middle of a drag: the run that went on is the truth, and two episodes from there are the same bits, one of
/// them of another touch.
/// @param at  ticks before; refreshes come each 33
void expect_the_run_goes_on(const Scene& scene, std::size_t at, double in_the_mean) {
  const Session session(scene);
  const SessionResult run = Session(scene).run();
  const std::span<const LocalFrame> way = run.tools[0].frames;
  Touch touch(session.body(), session.options());
  touch.place(run.tools[0].start);
  frames_of(touch, way.first(at));
  const TouchState state = touch.state();
  const std::vector<LocalFrame> on = frames_of(touch, way.subspan(at));
  ASSERT_GT(on.front().f_n, 0.01);
  touch.reset(state);
  EXPECT_EQ(touch.next_tick(), 0);
  const std::vector<LocalFrame> again = frames_of(touch, way.subspan(at));
  const auto apart_by = [&](std::span<const LocalFrame> others, std::size_t count) {
    double force = 0, apart = 0;
    for (std::size_t i = 0; i < count; ++i) {
      force += on[i].force.norm();
      apart += (on[i].force - others[i].force).norm();
    }
    return apart / force;
  };
  EXPECT_LT(apart_by(again, 1), 0.03);
  EXPECT_LT(apart_by(again, on.size()), in_the_mean);
  for (const LocalFrame& f : again) EXPECT_EQ(f.flags & (kPushedOut | kLostAnchor), 0u) << f.t;
  touch.reset(state);
  EXPECT_EQ(hash_of(frames_of(touch, way.subspan(at))), hash_of(again));
  Touch other(session.body(), session.options());
  other.reset(state);
  other.place(way[at - 1].pose);
  EXPECT_EQ(hash_of(frames_of(other, way.subspan(at))), hash_of(again)) << "placed where it is";
  other.reset(state);
  other.start();
  EXPECT_LT(apart_by(frames_of(other, way.subspan(at, 30)), 30), 2 * in_the_mean) << "in a thread of its own";
  other.stop();
}

TEST(TouchState, GoesOnFromItsState) {
  expect_the_run_goes_on(small_scene(), 199, 0.025);
  expect_the_run_goes_on(small_scene(), 215, 0.05);
}

/// Refined cells have yielded there, ten times as far as the others.
TEST(TouchState, GoesOnFromItsStateWithRefinedCells) {
  Scene scene = small_scene();
  scene.local.refine = "follow";
  expect_the_run_goes_on(scene, 199, 0.025);
  expect_the_run_goes_on(scene, 215, 0.05);
}

/// It is off at rest, so that the pace of refreshes counts, which goes along.
TEST(TouchState, GoesOnFromItsStateWithAWall) {
  Scene scene = small_scene();
  scene.local.reducer = "wall";
  expect_the_run_goes_on(scene, 215, 0.05);
}

/// Placed elsewhere, a tool has no contact and no force.
TEST(TouchState, HasNoContactOfAStateElsewhere) {
  const Session session(small_scene());
  const SessionResult run = Session(small_scene()).run();
  Touch touch(session.body(), session.options());
  touch.place(run.tools[0].start);
  frames_of(touch, std::span<const LocalFrame>(run.tools[0].frames).first(200));
  const TouchState state = touch.state();
  Pose away = run.tools[0].start;
  away.x.z() += 0.02;
  touch.reset(state);
  touch.place(away);
  const LocalFrame& frame = touch.tick(away);
  EXPECT_EQ(frame.mode, ContactMode::free);
  EXPECT_EQ(frame.force, Vec3::Zero());
}

TEST(TouchState, RefusesAStateOfAnotherBody) {
  const Session session(small_scene());
  Touch touch(session.body(), session.options());
  TouchState state = touch.state();
  EXPECT_FALSE(state.moment);
  touch.tick(Pose{});
  state.v[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(touch.reset(state), InputError);
  state.x.conservativeResize(3);
  EXPECT_THROW(touch.reset(state), InputError);
  const Session equal(small_scene());  // as many nodes, but its triangles are its own
  Touch other(equal.body(), equal.options());
  other.tick(Pose{});
  EXPECT_THROW(touch.reset(other.state()), InputError);
  EXPECT_EQ(touch.next_tick(), 1) << "nothing has changed";
}

/// Contacts of other methods and laws do not go on.
TEST(TouchState, RefusesContactsForOtherMethods) {
  Scene scene = small_scene();
  scene.local.method = "hold";
  const Session session(scene);
  Touch touch(session.body(), session.options());
  touch.tick(Pose{});
  const TouchState state = touch.state();
  EXPECT_THROW(touch.reset(state), InputError);
  touch.reset({state.x, state.v, nullptr});
  EXPECT_EQ(touch.next_tick(), 0);
}

/// The body alone: at rest as its state says, and clamped where it is.
TEST(TouchState, BeginsFromPositionsOfTheBody) {
  const Session session(small_scene());
  Touch touch(session.body(), session.options());
  TouchState state = touch.state();
  state.x.array() += 1e-3;
  touch.reset(state);
  VectorX x;
  touch.copy_positions(x);
  const VectorX& start = session.body().start().x;
  const std::vector<int>& fixed = session.body().model().fixed_nodes();
  ASSERT_FALSE(fixed.empty());
  for (int i = 0; i < static_cast<int>(x.size()) / 3; ++i) {
    const bool is_fixed = std::ranges::binary_search(fixed, i);
    EXPECT_NEAR((node(x, i) - node(start, i)).norm(), is_fixed ? 0 : std::sqrt(3.0) * 1e-3, 1e-12);
  }
}

}  // namespace
}  // namespace kt
