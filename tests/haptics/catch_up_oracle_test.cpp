// A local model that comes late and is caught up with is the one that was there all along.
#include "haptics/tick/catch_up.hpp"

#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_body.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kTop = 0.02;  // meshes/block.msh: 0.08 x 0.05 x 0.02 m, 5 mm cells

const SoftBlock& body() {
  static const SoftBlock made{SoftBlockOptions{.young = 5e3, .reducer = "full", .reach = 0.02}};
  return made;
}

Vec3 above(const ToolShape& tool) { return {0.0212, 0.0263, kTop + tool.radius + 0.001}; }

/// Down, then along: the place after a tick.
Vec3 place(const ToolShape& tool, int tick) {
  Vec3 out = above(tool);
  out.z() -= 0.0025 * std::min(1.0, tick / 60.0);
  out.x() += 4e-5 * std::max(0, tick - 60);
  return out;
}

class CatchUpWith : public testing::TestWithParam<ToolShape> {};

TEST_P(CatchUpWith, AModelThatCameLateGivesTheForcesOfTheOneThatWasThere) {
  const ToolShape tool = GetParam();
  const Friction friction{0.3, 0.3};
  Press always(body(), tool, "coulomb", friction, above(tool));
  Press late(body(), tool, "coulomb", friction, above(tool));
  CatchUp catch_up({&tool, 1}, body().options.h, make_contact_solver("coulomb", friction));
  std::unique_ptr<PreparedLocalModel> coming;
  for (int tick = 1; tick <= 160; ++tick) {
    if (tick == 101) {  // made of the motion and the contacts after tick 100
      coming = body().local_model(above(tool));
      LocalMotion motion = make_local_motion(body().model->mesh().num_nodes());
      record_motion(late.local().model(), 100, motion);
      carry_motion(motion, *coming);
      place_contacts(*coming, late.local().samples(), late.local().model().state.sliding);
    }
    if (tick == 131) {  // and adopted 30 ticks later
      for (int i = 101; i < tick; ++i) {
        const ToolSweep sweep{place(tool, i - 1), place(tool, i)};
        catch_up.step(*coming, {&sweep, 1});
      }
      coming->caught_up = true;
      late.local().adopt(std::move(coming));
    }
    const LocalFrame a = always.go_to(place(tool, tick)), b = late.go_to(place(tool, tick));
    ASSERT_LE((a.force - b.force).norm(), 1e-7 * std::max(1e-3, a.force.norm())) << "tick " << tick;
    ASSERT_EQ(a.mode, b.mode) << "tick " << tick;
    ASSERT_EQ(a.triangle, b.triangle) << "tick " << tick;
    if (tick == 160) {
      EXPECT_GT(a.f_n, 0.01);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Both, CatchUpWith, testing::Values(kPointTool, kSphereTool),
                         [](const auto& tool) { return tool.param.radius > 0 ? "sphere" : "point"; });

/// It began inside, and is pushed out over 60 ms: a model that is run in and did not know would let it go.
TEST(Overlap, GoesOnAcrossARefresh) {
  Scene scene = small_scene("point");
  const Vec3 inside(0.03, 0.026, 0.02 - 1e-5);
  scene.tool.path = {std::nullopt, std::vector<Waypoint>{{0, inside}, {0.15, inside}}, std::nullopt, std::nullopt,
                     std::nullopt};
  scene.local.blend_ms = 0;  // nothing is hidden
  scene.duration = 0.15;
  const SessionResult run = Session(scene).run();
  ASSERT_GT(run.refreshes.size(), 3u);
  EXPECT_EQ(run.tools[0].missed_impacts, 0);
  for (const LocalFrame& f : run.tools[0].frames) ASSERT_NE(f.mode, ContactMode::free) << "at " << f.t;
  double jump = 0, most = 0;
  for (std::size_t i = 2; i < run.tools[0].frames.size(); ++i) {
    jump = std::max(jump, (run.tools[0].frames[i].force - run.tools[0].frames[i - 1].force).norm());
    most = std::max(most, run.tools[0].frames[i].force.norm());
  }
  EXPECT_LT(jump, 0.05 * most);
}

TEST(LeftPatch, FadesTheForceAndFindsTheContactAgainInANewPatch) {
  const SoftBlock small{SoftBlockOptions{.young = 5e3, .reducer = "condensed", .reach = 0.006, .blend = 0.012}};
  const ToolShape tool = kSphereTool;
  Press press(small, tool, "coulomb", {0.1, 0.1}, above(tool));
  press.move(place(tool, 60), 60);
  double sum = 0, jump = 0;
  int ticks = 0, off = 0;
  Vec3 last = press.go_to(press.tool()).force;
  bool adopted = false;
  for (int i = 0; i < 900; ++i) {
    const Vec3 next = press.tool() + Vec3(3e-5, 0, 0);
    if (off > 30 && !adopted) {  // the new patch comes late
      press.local().adopt(small.local_model(next));
      adopted = true;
    }
    const LocalFrame frame = press.go_to(next);
    ASSERT_TRUE(frame.force.allFinite());
    if (i > 20) jump = std::max(jump, (frame.force - last).norm());  // the drag has begun
    off += frame.mode == ContactMode::free;
    if (off == 0) sum += frame.force.norm(), ++ticks;
    last = frame.force;
    if (adopted && i % 10 == 0) {
      press.local().adopt(small.local_model(next));
    }
    if (!adopted && frame.mode == ContactMode::free) {
      EXPECT_TRUE(frame.flags & kLeftPatch);
    }
    if (next.x() > 0.06) break;
  }
  ASSERT_TRUE(adopted) << "the tool never left the patch";
  EXPECT_LE(jump, 0.1 * sum / ticks);
  EXPECT_GT(last.norm(), 0.5 * sum / ticks) << "contact was not found again";
  EXPECT_LT(press.penetration(), 1e-5);
}

}  // namespace
}  // namespace kt
