// The haptic tick against what statics, friction and geometry say about it.
#include "haptics/tick/local_simulation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/support/haptics_body.hpp"

namespace kt {
namespace {

// meshes/block.msh: 0.08 x 0.05 x 0.02 m, 5 mm cells.
constexpr double kTop = 0.02;
const Vec3 kAbove(0.0412, 0.0263, kTop + 0.001);  // inside a triangle

Vec3 above(const ToolShape& tool) { return kAbove + tool.radius * Vec3::UnitZ(); }
Vec3 pressed(const ToolShape& tool, double depth) { return above(tool) - (0.001 + depth) * Vec3::UnitZ(); }

const SoftBlock& block() {
  static const SoftBlock body;
  return body;
}
const SoftBlock& small_block() {  // a patch with a rim, as in a session
  static const SoftBlock body{SoftBlockOptions{.reach = 0.012}};
  return body;
}

class BothTools : public testing::TestWithParam<ToolShape> {};
INSTANTIATE_TEST_SUITE_P(Press, BothTools, testing::Values(kPointTool, kSphereTool), [](const auto& tool) {
  return tool.param.kind == ToolShape::Kind::point ? "point" : "sphere";
});

/// Force that holds one contact point of the linear local model at the tool, by statics: f = (J K^-1 J^T)^-1 gap.
Vec3 static_force(const LocalModel& model, const Contact& contact, const Vec3& displacement) {
  const Triangle& t = model.patch.triangles[contact.triangle];
  MatrixX J = MatrixX::Zero(3, model.basis.rows());
  for (int c = 0; c < 3; ++c) J.block<3, 3>(0, 3 * t[c]) = contact.bary[c] * Mat3::Identity();
  const MatrixX reduced = J * model.basis;
  const Mat3 compliance = reduced * MatrixX(model.stiffness).ldlt().solve(MatrixX(reduced.transpose()));
  return -compliance.inverse() * displacement;  // of the tool: against what it imposes
}

TEST(StaticPress, PointForceIsTheStiffnessOfTheReducedModel) {
  const Vec3 end = pressed(kPointTool, 0.001);
  Press press(block(), kPointTool, "coulomb", {50, 50}, above(kPointTool));
  press.move(end, 50);
  const LocalFrame frame = press.move(end, 3000);
  ASSERT_EQ(frame.mode, ContactMode::stick);
  const LocalModel& m = press.local().model().model;
  ASSERT_EQ(frame.contacts, 1);
  const Contact& held = press.local().model().state.anchors.contacts[0];
  const Triangle& t = m.patch.triangles[held.triangle];
  Vec3 material = Vec3::Zero();  // where the stuck point was at rest
  for (int c = 0; c < 3; ++c) material += held.bary[c] * node(m.x0, t[c]);
  const Vec3 expected = static_force(m, held, end - material);
  EXPECT_LT((frame.force - expected).norm(), 1e-6 * expected.norm())
      << frame.force.transpose() << " expected " << expected.transpose();
}

TEST(StaticPress, FrictionlessForceIsTheStiffnessAlongTheNormal) {
  const Vec3 end = pressed(kPointTool, 0.0005);
  Press press(block(), kPointTool, "coulomb", {0, 0}, above(kPointTool));
  press.move(end, 50);
  const LocalFrame frame = press.move(end, 3000);
  ASSERT_EQ(frame.mode, ContactMode::slide);
  // Balance of the whole local model at rest: stiffness q - f0 = J^T (impulse / h).
  const PreparedLocalModel& local = press.local().model();
  const Contact& held = local.state.anchors.contacts[0];
  VectorX residual = local.model.f0 - local.model.stiffness * local.state.q;
  for (int c = 0; c < 3; ++c)
    residual -= local.patch_basis.middleRows(3 * local.model.patch.triangles[held.triangle][c], 3).transpose() *
                (held.bary[c] * frame.force);
  EXPECT_LT(residual.norm(), 1e-6 * frame.force.norm());
  EXPECT_LT((frame.force - frame.force.dot(held.normal) * held.normal).norm(), 1e-12 * frame.force.norm());
}

TEST_P(BothTools, StickingPointGoesWithTheTool) {
  const ToolShape tool = GetParam();
  const Vec3 down = pressed(tool, 0.001);
  Press press(block(), tool, "coulomb", {1000, 1000}, above(tool));
  press.move(down, 100);
  const auto stuck_at = [&](const Contact& c) {
    const VectorX x = press.patch_positions();
    const Triangle& t = press.local().model().model.patch.triangles[c.triangle];
    return Vec3(c.bary[0] * node(x, t[0]) + c.bary[1] * node(x, t[1]) + c.bary[2] * node(x, t[2]));
  };
  const Contact first = press.local().model().state.anchors.contacts[0];
  const Vec3 offset = stuck_at(first) - press.tool();
  double drift = 0;
  press.move(down + Vec3(0.002, 0.001, 0), 200, [&](const LocalFrame& frame) {
    EXPECT_EQ(frame.mode, ContactMode::stick);
    drift = std::max(drift, (stuck_at(first) - press.tool() - offset).norm());
  });
  // A point sticks exactly. A sphere rolls over the patch while its contact sticks: the point may move by less than the
  // surface turns.
  EXPECT_LT(drift, tool.radius > 0 ? 5e-4 : 1e-6);
}

TEST_P(BothTools, WithoutFrictionThereIsNoTangentialForce) {
  const ToolShape tool = GetParam();
  Press press(block(), tool, "coulomb", {0, 0}, above(tool));
  double largest_ratio = 0, normal = 0;
  const auto look = [&](const LocalFrame& frame) {
    largest_ratio = std::max(largest_ratio, frame.cone_ratio);
    normal = std::max(normal, frame.f_n);
  };
  press.move(pressed(tool, 0.002), 100, look);
  press.move(pressed(tool, 0.002) + Vec3(0.02, 0.003, 0), 400, look);
  EXPECT_GT(normal, 0.01);
  EXPECT_LT(largest_ratio, 1e-12);
}

TEST_P(BothTools, SlipsAtMuAndSticksBelow) {
  const ToolShape tool = GetParam();
  const double mu = 0.4;
  Press press(block(), tool, "coulomb", {mu, mu}, above(tool));
  press.move(pressed(tool, 0.0015), 100);
  int sticking = 0, slipping = 0;
  press.move(pressed(tool, 0.0015) + Vec3(0.015, 0, 0), 500, [&](const LocalFrame& frame) {
    ASSERT_LE(frame.cone_ratio, mu * (1 + 1e-9));
    if (frame.contacts == 1 && frame.mode == ContactMode::frictional_slide) {
      ASSERT_NEAR(frame.f_t, mu * frame.f_n, 1e-9 * frame.f_n);
      ASSERT_LT(frame.force.x(), 0) << "against the drag";
    }
    sticking += frame.mode == ContactMode::stick;
    slipping += frame.mode == ContactMode::frictional_slide;
  });
  EXPECT_GT(sticking, 5) << "at first";
  EXPECT_GT(slipping, 300) << "then";
}

TEST(StickSlip, KineticFrictionIsWeakerOnceItSlides) {
  Press press(block(), kPointTool, "coulomb", {0.8, 0.3}, above(kPointTool));
  press.move(pressed(kPointTool, 0.0015), 100);
  double highest_stuck = 0;
  press.move(pressed(kPointTool, 0.0015) + Vec3(0.01, 0, 0), 500, [&](const LocalFrame& frame) {
    if (frame.mode == ContactMode::stick) highest_stuck = std::max(highest_stuck, frame.cone_ratio);
    if (frame.mode == ContactMode::frictional_slide) {
      ASSERT_NEAR(frame.cone_ratio, 0.3, 1e-9);
    }
  });
  EXPECT_GT(highest_stuck, 0.6);
  EXPECT_LE(highest_stuck, 0.8);
}

TEST_P(BothTools, ReleaseLeavesNoForce) {
  const ToolShape tool = GetParam();
  Press press(block(), tool, "coulomb", {0.5, 0.5}, above(tool));
  press.move(pressed(tool, 0.002), 100);
  EXPECT_GT(press.move(pressed(tool, 0.002), 50).f_n, 0.01);
  double pull = 0;
  press.move(above(tool) + Vec3(0, 0, 0.005), 100, [&](const LocalFrame& f) { pull = std::min(pull, f.force.z()); });
  EXPECT_GE(pull, 0) << "a surface never pulls";
  const LocalFrame last = press.move(press.tool(), 1);
  EXPECT_EQ(last.mode, ContactMode::free);
  EXPECT_TRUE(last.force.isZero(0));
  EXPECT_TRUE(press.local().samples().empty());
}

TEST_P(BothTools, NeverGetsInside) {
  const ToolShape tool = GetParam();
  for (double mu : {0.0, 0.5}) {
    Press press(block(), tool, "coulomb", {mu, mu}, above(tool));
    double deepest = 0;
    const auto look = [&](const LocalFrame&) { deepest = std::max(deepest, press.penetration()); };
    press.move(pressed(tool, 0.002), 50, look);
    press.move(pressed(tool, 0.002) + Vec3(0.02, 0.005, 0), 300, look);
    press.move(above(tool) + Vec3(0.02, 0.005, 0), 20, look);
    press.move(pressed(tool, 0.002), 60, look);  // hits the surface in the middle of a tick, aslant
    EXPECT_LT(deepest, tool.radius > 0 ? 0.01 * tool.radius : 1e-6) << "mu " << mu;
  }
}

TEST_P(BothTools, GivesNoEnergyAway) {
  const ToolShape tool = GetParam();
  Press press(block(), tool, "coulomb", {0.3, 0.3}, above(tool));
  double work = 0, lowest = 0, highest = 0;
  Vec3 before = press.tool();
  const auto look = [&](const LocalFrame& f) {
    work -= f.force.dot(f.pose.x - before);
    before = f.pose.x;
    lowest = std::min(lowest, work);
    highest = std::max(highest, work);
  };
  for (int stroke = 0; stroke < 5; ++stroke) {
    press.move(pressed(tool, 0.0015), 40, look);
    press.move(pressed(tool, 0.0015) + Vec3(0.005, 0.002, 0), 80, look);
    press.move(above(tool), 30, look);
  }
  EXPECT_GT(highest, 1e-6);
  EXPECT_GT(lowest, -1e-3 * highest);
}

TEST_P(BothTools, ImpactTakesPlaceWithinTheTick) {
  const ToolShape tool = GetParam();
  Press press(block(), tool, "coulomb", {0.5, 0.5}, above(tool));
  const LocalFrame frame = press.go_to(above(tool) - 0.002 * Vec3::UnitZ());  // the surface is half-way
  EXPECT_NEAR(frame.toi, 0.5, 1e-6);
  EXPECT_EQ(frame.events, 1);
  EXPECT_GT(frame.f_n, 0);
}

TEST(Adopt, TheSameModelAgainChangesNothing) {
  Press press(small_block(), kPointTool, "coulomb", {0.5, 0.5}, above(kPointTool));
  Press refreshed(small_block(), kPointTool, "coulomb", {0.5, 0.5}, above(kPointTool));
  const Vec3 down = pressed(kPointTool, 0.001);
  press.move(down, 50);
  refreshed.move(down, 50);
  for (int i = 0; i < 100; ++i) {
    if (i % 10 == 0) refreshed.local().adopt(small_block().local_model(above(kPointTool)));
    const Vec3 next = down + i * 2e-5 * Vec3::UnitX();
    const LocalFrame a = press.go_to(next), b = refreshed.go_to(next);
    EXPECT_LT((a.force - b.force).norm(), 1e-9 * a.force.norm()) << "tick " << i;
    EXPECT_EQ(a.mode, b.mode);
    EXPECT_EQ(a.triangle, b.triangle);
  }
}

TEST(Adopt, CarriesPositionsVelocitiesAndContactsToAnotherPatch) {
  Press press(small_block(), kPointTool, "coulomb", {0.5, 0.5}, above(kPointTool));
  press.move(pressed(kPointTool, 0.001), 50);
  const PreparedLocalModel& before = press.local().model();
  const VectorX x_before = press.patch_positions();
  const VectorX v_before = before.patch_basis * before.state.q_rate;
  const std::vector<int> nodes_before = before.model.patch.global_node;
  const Contact held = before.state.anchors.contacts[0];
  const int triangle = before.model.patch.global_triangle[held.triangle];

  const auto old = press.local().adopt(small_block().local_model(above(kPointTool) + Vec3(0.006, 0, 0)));
  ASSERT_NE(old, nullptr);
  const PreparedLocalModel& after = press.local().model();
  const VectorX x_after = press.patch_positions();
  const VectorX v_after = after.patch_basis * after.state.q_rate;
  int shared = 0;
  for (int i = 0; i < after.model.patch.num_vertices(); ++i) {
    const auto at = std::ranges::find(nodes_before, after.model.patch.global_node[i]);
    if (at == nodes_before.end()) continue;
    const int k = static_cast<int>(at - nodes_before.begin());
    EXPECT_LT((node(x_after, i) - node(x_before, k)).norm(), 1e-15);
    EXPECT_LT((node(v_after, i) - node(v_before, k)).norm(), 1e-12);
    ++shared;
  }
  EXPECT_GT(shared, 10);
  EXPECT_LT(shared, after.model.patch.num_vertices());
  ASSERT_EQ(after.state.anchors.count, 1);
  const Contact& carried = after.state.anchors.contacts[0];
  EXPECT_EQ(after.model.patch.global_triangle[carried.triangle], triangle);
  EXPECT_EQ(carried.bary, held.bary);
}

TEST(Adopt, SaysSoWhenThePatchDoesNotHoldTheContact) {
  Press press(small_block(), kPointTool, "coulomb", {0.5, 0.5}, above(kPointTool));
  press.move(pressed(kPointTool, 0.001), 50);
  press.local().adopt(small_block().local_model(Vec3(0.075, 0.005, kTop)));
  const LocalFrame frame = press.go_to(press.tool());
  EXPECT_TRUE(frame.flags & kLostAnchor);
  EXPECT_TRUE(frame.force.allFinite());
}

/// The tool is where the surface has no contact with it that was seen: it is pushed out over some ticks, not at once.
void expect_pushed_out(Press& press) {
  const LocalFrame first = press.go_to(press.tool());
  EXPECT_NE(first.mode, ContactMode::free);
  EXPECT_GT(press.penetration(), 5e-4);
  LocalFrame last;
  double largest_jump = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 before = i == 0 ? first.force : last.force;
    last = press.go_to(press.tool());
    largest_jump = std::max(largest_jump, (last.force - before).norm());
  }
  EXPECT_LT(press.penetration(), 1e-9);
  EXPECT_GT(last.f_n, 0.01);
  EXPECT_LT(largest_jump, 0.1 * last.f_n);
}

TEST(StartInside, IsPushedOutOverSomeTicks) {
  const SoftBlock body;
  const double top = bounds(body.model->mesh()).max.z();
  Press press(body, kSphereTool, "coulomb", {0.3, 0.3}, Vec3(0.03, 0.026, top + kSphereTool.radius - 1e-3));
  expect_pushed_out(press);
}

TEST(Refresh, ThatMovesTheSurfaceThroughTheToolIsTouched) {
  const SoftBlock body;
  const double top = bounds(body.model->mesh()).max.z();
  Press press(body, kSphereTool, "coulomb", {0.3, 0.3}, Vec3(0.03, 0.026, top + kSphereTool.radius + 5e-4));
  EXPECT_EQ(press.move(press.tool(), 5).mode, ContactMode::free);
  State raised = rest_state(*body.model);
  for (int i = 0; i < body.model->mesh().num_nodes(); ++i)
    node(raised.x, i).z() += 1.5e-3 * node(raised.x, i).z() / top;
  auto next = body.local_model(raised, press.tool());
  next->caught_up = true;
  next->model.f0.setZero();  // at rest there
  press.local().adopt(std::move(next));
  expect_pushed_out(press);
}

TEST(LeftPatch, IsFlaggedOnTheRim) {
  Press press(small_block(), kPointTool, "coulomb", {0.1, 0.1}, above(kPointTool));
  EXPECT_FALSE(press.move(pressed(kPointTool, 0.0005), 50).flags & kLeftPatch);
  EXPECT_TRUE(press.move(pressed(kPointTool, 0.0005) + Vec3(0.018, 0, 0), 400).flags & kLeftPatch);
}

}  // namespace
}  // namespace kt
