// Refined cells with what a scene may have beside one ball: two tools, two threads, tools of other shapes, regions of
// friction, nearly incompressible bodies, large strain.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/findings/run_findings.hpp"
#include "haptics/touch/touch.hpp"
#include "tests/support/fine_block.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

double last_force(const SessionResult& r, std::size_t tool = 0) { return r.tools[tool].frames.back().f_n; }

void expect_refined(const SessionResult& r) {
  EXPECT_EQ(r.refresh.fineness.empty(), false);
  for (const ToolRun& tool : r.tools) EXPECT_EQ(tool.lost.free_ticks_inside, 0);
}

// Far apart each has the force that it has alone. The cells of two are larger (a tick holds half as many places of
// each), which changes it by some hundredths.
TEST(FineScenes, TwoToolsHaveTheForceOfOne) {
  const BlockPress press{.x = 2, .y = 1};
  Scene two = scene_of(press);
  two.second_tool = two.tool;
  two.second_tool->path.press_drag->at = std::array{0.5 * kBlockWide - 0.012, 0.5 * kBlockWide - 0.006};
  const SessionResult r = Session(two, block_of(press)).run();
  expect_refined(r);
  const double alone = last_force(run(press));
  EXPECT_NEAR(last_force(r, 0) / alone, 1, 0.07);
  EXPECT_NEAR(last_force(r, 1) / alone, 1, 0.1);
}

// Whatever the clock did, the run is repeated from its record.
TEST(FineScenes, TwoThreadsAreRepeatedBitForBit) {
  const BlockPress press{.speed = 0.01, .mu = 0.3, .duration = 0.5, .link = "thread"};
  const SessionResult live = run(press);
  expect_refined(live);
  EXPECT_EQ(Session(scene_of(press), block_of(press)).run(replay_of(live)).hash, live.hash);
}

std::vector<double> press_with(const ToolShape& shape, double above, const std::string& refine) {
  const BlockPress press{.refine = refine};
  Session session(scene_of(press), block_of(press));
  TouchOptions options = session.options();
  options.tools[0].shape = shape;
  Touch touch(session.body(), options);
  const auto pose = [&](int tick) {
    const double depth = 0.0016 * std::min(1.0, tick / 150.0) - 1e-4;
    return Pose{Vec3(0.5 * kBlockWide + 0.0007, 0.5 * kBlockWide + 0.0011, kBlockThick + above - depth)};
  };
  touch.place(pose(0));
  std::vector<double> out;
  for (int i = 0; i <= 300; ++i) out.push_back(touch.tick(pose(i)).force.z());
  return out;
}

// Forces of a body that is fine everywhere: bench/fine_reference_table.cpp.
TEST(FineScenes, ToolsOfOtherShapesTouchRefinedCells) {
  const double ball = press_with({ToolShape::Kind::sphere, 0.008}, 0.008, "follow").back();
  EXPECT_NEAR(ball / 0.1006, 0.96, 0.05);
  const double triangles = press_with(ball_tool(0.008, 8, 0.001), 0.008, "follow").back();
  EXPECT_NEAR(triangles / ball, 1, 0.1) << "the same ball, of 224 triangles";
  const ToolShape capsule = make_capsule(0.004, 0.02);
  const double upright = press_with(capsule, 0.014, "follow").back();
  EXPECT_GT(press_with(capsule, 0.014, "off").back() / upright, 2) << "the mesh's force, which is not the body's";
}

// In a region the friction is the region's, at the places of refined cells as at nodes.
TEST(FineScenes, RegionsHaveTheirOwnFriction) {
  const BlockPress press{.x = -2, .speed = 0.02, .mu = 0.2, .duration = 1.1};
  Scene scene = scene_of(press);
  scene.tool.path.press_drag->direction = {1, 0, 0};
  scene.contact.regions = {{{Vec3(0.5 * kBlockWide, -1, -1), Vec3(1, 1, 1)}, 0.6, 0.6}};
  const SessionResult r = Session(scene, block_of(press)).run();
  expect_refined(r);
  const auto ratio = [&](std::size_t i) { return r.tools[0].frames[i].f_t / r.tools[0].frames[i].f_n; };
  EXPECT_NEAR(ratio(520), 0.2, 0.03);
  EXPECT_NEAR(ratio(r.tools[0].frames.size() - 1), 0.6, 0.09);
}

// What the cells do to a nearly incompressible body is told: by the run, and by a Touch.
TEST(FineScenes, TellTheForceToExpect) {
  BlockPress press;
  Scene scene = scene_of(press);
  for (const double poisson : {0.3, 0.48}) {
    scene.object.model.poisson = poisson;
    const Session session(scene, block_of(press));
    const SessionResult r = Session(scene, block_of(press)).run();
    const MeasuredRun measured = measure_run(session, r);
    ASSERT_TRUE(measured.width);
    EXPECT_GT(measured.width->fineness, 0.5);
    EXPECT_LT(measured.width->fineness, 1.65);
    EXPECT_NEAR(measured.width->factor, poisson < 0.4 ? 1.06 : 1.13, 0.015) << poisson;
  }
  press.type = "msd";
  press.refine = "off";
  Session springs(scene_of(press), block_of(press));
  Touch touch(springs.body(), springs.options());
  const Pose above{Vec3(0.5 * kBlockWide, 0.5 * kBlockWide, kBlockThick + kBallRadius + 1e-3)};
  touch.place(above);
  touch.tick(above);
  EXPECT_TRUE(touch.findings().empty()) << "nothing is touched";
  for (int i = 1; i <= 100; ++i) touch.tick(Pose{above.x - Vec3(0, 0, 2e-5 * i)});
  EXPECT_TRUE(std::isnan(touch.status().fineness));
  EXPECT_GT(touch.status().force_factor, 2);
  const std::vector<Finding> found = touch.findings();
  EXPECT_TRUE(std::ranges::any_of(found, [](const Finding& f) {
    return f.where == "object.mesh" && !f.cures.empty() && f.cures[0].key == "local.refine";
  })) << "one tells that the cells are too coarse";
}

// They stay where the tool first touched: no time at refreshes once the contact no longer grows, the continuum's force
// however deep the tool presses there, and that of the cells as they are elsewhere, told with its cure.
TEST(FineScenes, CellsOfTheSetUpStayWhereTheyAre) {
  const auto is_unrefined = [](const LocalFrame& f) { return (f.flags & kUnrefined) != 0; };
  // N, of a body that is fine everywhere: docs/accuracy_and_speed.md, bench/fine_drag_table block
  for (const auto& [depth, continuum] : {std::pair(0.0015, 0.0915), {0.003, 0.264}}) {
    const SessionResult kept = run({.depth = depth, .duration = 0.8, .refine = "set-up"});
    expect_refined(kept);
    EXPECT_NEAR(last_force(kept) / continuum, 1.04, 0.08) << depth;
    EXPECT_EQ(std::ranges::count_if(kept.tools[0].frames, is_unrefined), 0) << depth;
    auto [part, refine_ms] = kept.refresh.parts_ms[2];
    EXPECT_EQ(part, "refine");
    const auto middle = refine_ms.end() - 5;  // of the last nine, whatever runs beside
    std::nth_element(refine_ms.end() - 9, middle, refine_ms.end());
    EXPECT_LT(*middle, 0.3) << "nothing is made anew";
  }

  const BlockPress away{.x = -2, .speed = 0.04, .duration = 0.8, .refine = "set-up"};
  Session session(scene_of(away), block_of(away));
  const SessionResult left = session.run();
  const auto& frames = left.tools[0].frames;
  EXPECT_EQ(frames[280].flags & kUnrefined, 0U);
  EXPECT_NE(frames.back().flags & kUnrefined, 0U);
  EXPECT_GT(frames.back().f_n / frames[300].f_n, 1.5) << "the mesh's force";
  const std::vector<Finding> found = all_findings(session, left);
  EXPECT_TRUE(std::ranges::any_of(found, [](const Finding& f) {
    return !f.cures.empty() && f.cures[0].key == "local.refine" && f.cures[0].value == "follow";
  }));
}

// A tool that begins far from where it will touch has its cells where it touches, also where models come late.
TEST(FineScenes, CellsOfTheSetUpAreWhereTheToolTouches) {
  for (const double late_ms : {0.0, 25.0}) {
    Scene scene = scene_of({.duration = 0.8, .refine = "set-up"});
    if (late_ms > 0) {
      scene.link.charge_refreshes = "given";
      scene.link.refresh_ms = late_ms;
    }
    scene.tool.path.press_drag.reset();
    const double x = 0.5 * kBlockWide;
    scene.tool.path.waypoints = {{0, {x - 0.02, x, kBlockThick + kBallRadius + 5e-3}},
                                 {0.3, {x + 0.01, x, kBlockThick + kBallRadius + 1e-3}},
                                 {0.6, {x + 0.01, x, kBlockThick + kBallRadius - 1.5e-3}},
                                 {0.8, {x + 0.01, x, kBlockThick + kBallRadius - 1.5e-3}}};
    const SessionResult r = Session(scene, block_of({})).run();
    EXPECT_EQ(r.tools[0].frames.back().flags & kUnrefined, 0U) << late_ms;
    EXPECT_NEAR(last_force(r) / 0.0915, 1.04, 0.1) << late_ms;
  }
}

TEST(FineScenes, APointHasNoContactToRefine) {
  Scene scene = scene_of({});
  scene.tool.shape = "point";
  try {
    Session(scene, block_of({})).run();
    FAIL() << "a point with refined cells";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("not with tool.shape point"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace kt
