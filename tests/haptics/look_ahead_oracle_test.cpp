// The body as it will be, against the body as it became.
#include "core/body/node_weights.hpp"
#include "haptics/refresh/look_ahead.hpp"

#include <gtest/gtest.h>

#include "collision/shape/closest_point.hpp"
#include "core/global/global_simulation.hpp"
#include "lab/study/reference.hpp"
#include "models/model.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

std::vector<LocalReport> reports_along(const Vec3& per_tick, int ticks) {
  std::vector<LocalReport> out(static_cast<std::size_t>(ticks));
  for (int i = 0; i < ticks; ++i) {
    out[static_cast<std::size_t>(i)].tick = i;
    out[static_cast<std::size_t>(i)].tools[0].pose.x = i * per_tick;
  }
  return out;
}

TEST(ToolVelocity, IsThatOfTheLastTicks) {
  const Vec3 step(1e-5, 0, -2e-5);
  EXPECT_EQ(tool_velocity({}, 1000), Vec3::Zero());
  EXPECT_EQ(tool_velocity(reports_along(step, 1), 1000), Vec3::Zero());
  EXPECT_NEAR((tool_velocity(reports_along(step, 3), 1000) - 1000 * step).norm(), 0, 1e-12);
  std::vector<LocalReport> turned = reports_along(step, 30);
  for (LocalReport& report : reports_along(Vec3::UnitX() * 1e-5, 11)) turned.push_back(report);
  for (std::size_t i = 0; i < turned.size(); ++i) turned[i].tick = static_cast<int>(i);
  EXPECT_NEAR((tool_velocity(turned, 1000) - Vec3(0.01, 0, 0)).norm(), 0, 1e-12);
}

/// Reports that never came over a network leave the velocity what it is.
TEST(ToolVelocity, GoesByTheTicksThatAreThere) {
  std::vector<LocalReport> some = reports_along(Vec3(1e-5, 0, 0), 30);
  some.erase(some.begin() + 24, some.begin() + 28);
  EXPECT_NEAR((tool_velocity(some, 1000) - Vec3(0.01, 0, 0)).norm(), 0, 1e-12);
}

/// Of the last 10 ms: a tool that turned round 12 ms ago goes the new way at every rate.
TEST(ToolVelocity, LooksBackByTimeAndNotByTicks) {
  for (const int rate : {250, 1000, 4000, 8000, 10000}) {
    std::vector<LocalReport> reports(static_cast<std::size_t>(rate / 20 + 1));
    const double end = static_cast<double>(reports.size() - 1) / rate, turn = end - 0.012;
    for (std::size_t i = 0; i < reports.size(); ++i)
      reports[i].tools[0].pose.x = std::abs(static_cast<double>(i) / rate - turn) * Vec3(0.1, 0, 0);
    for (std::size_t i = 0; i < reports.size(); ++i) reports[i].tick = static_cast<int>(i);
    EXPECT_NEAR((tool_velocity(reports, rate) - Vec3(0.1, 0, 0)).norm(), 0, 1e-9) << rate;
    for (std::size_t i = 0; i < reports.size(); ++i)  // and noise of the encoder counts for as little
      reports[i].tools[0].pose.x = (i % 2 == 0 ? 1e-6 : 0.0) * Vec3::UnitX();
    EXPECT_LE(tool_velocity(reports, rate).norm(), 1e-6 / 0.0079) << rate;
  }
}

TEST(LastHolds, SplitTheForceOnTheBody) {
  Surface surface;
  surface.triangles = {{1, 2, 3}};
  LocalReport report;
  report.count = 1;
  report.samples[0] = {.triangle = 0, .bary = {1, 0, 0}, .impulse = {2e-4, 0, -1e-3}, .normal = Vec3::UnitZ()};
  const std::vector<ContactHold> holds = last_holds({&report, 1}, ContactNodes(surface), 1000, ToolShape{});
  ASSERT_EQ(holds.size(), 1u);
  EXPECT_EQ(holds[0].moves.of(VectorX::LinSpaced(12, 0, 11)), Vec3(3, 4, 5));
  EXPECT_DOUBLE_EQ(holds[0].force, 1);
  EXPECT_EQ(holds[0].friction, Vec3(0.2, 0, 0));
}

TEST(MovedHolds, SlideOverTheSurfaceThatFacesTheTool) {
  const Mesh mesh = kuhn_block(8, 4, 1, 0.01);  // a sheet
  const Surface surface = make_surface(mesh);
  const auto place = [&](const ContactHold& hold) { return hold.moves.of(mesh.x); };
  // Of a triangle on top, pushed deeper than half the sheet.
  ContactHold start;
  for (const Triangle& t : surface.triangles)
    if (node(mesh.x, t[0]).z() + node(mesh.x, t[1]).z() + node(mesh.x, t[2]).z() > 0.0299)
      start = {.moves = {t, Vec3::Constant(1. / 3)}, .normal = Vec3::UnitZ()};
  start.point = place(start) - 0.008 * start.normal;
  const Vec3 step(place(start).x() > 0.04 ? -0.023 : 0.023, 0.001, -0.007);
  ContactHold stuck = start;
  stuck.sticks = true;
  stuck.friction = Vec3::UnitX();
  const std::vector<ContactHold> moved = moved_holds({start, stuck}, surface, {}, mesh.x, step);
  EXPECT_NEAR((place(moved[0]) - place(start) - Vec3(step.x(), step.y(), 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((moved[0].point - start.point - step).norm(), 0, 1e-12);
  EXPECT_EQ(place(moved[1]), place(start));
  EXPECT_EQ(moved[1].friction, Vec3::Zero());
}

struct SlidBlock {
  Mesh mesh = kuhn_block(8, 4, 4, 0.005);
  std::unique_ptr<DeformableModel> model = make_model("fem", mesh,
                                                      {.young = 1e4,
                                                       .poisson = 0.4,
                                                       .density = 1000,
                                                       .damping_stiffness = 2e-3,
                                                       .fixed_nodes = nodes_below(mesh, 1e-6),
                                                       .material = "neo_hookean"});
  Surface surface = make_surface(mesh);
  /// 2 mm deep at x.
  ContactHold hold(double x) const {
    ContactHold out{.normal = Vec3::UnitZ(), .point = {x, 0.0112, 0.018}};
    double nearest = 1;
    for (const Triangle& t : surface.triangles) {
      const ClosestPoint at =
          closest_point_on_triangle({x, 0.0112, 0.02}, node(mesh.x, t[0]), node(mesh.x, t[1]), node(mesh.x, t[2]));
      if (at.distance_sq >= nearest) continue;
      nearest = at.distance_sq;
      out.moves = {t, at.bary};
    }
    return out;
  }
};

TEST(LookAhead, IsNearerToWhatTheBodyBecomesThanWhatItIs) {
  const SlidBlock block;
  GlobalSimulation simulation(*block.model, make_integrator("implicit_euler"), 0.1);
  const double dt = 0.005, speed = 0.05;
  const auto drag_to = [&](double t) {
    for (int i = 1; simulation.state().t < t - 1e-9; ++i) {
      const double next = simulation.state().t + dt;
      const ContactHold hold = block.hold(0.013 + speed * next);
      simulation.advance(next, {}, {&hold, 1});
    }
  };
  drag_to(0.1);
  const State now = simulation.state();
  const std::vector<ContactHold> holds =
      moved_holds({block.hold(0.013 + speed * 0.1)}, block.surface, {}, block.mesh.x, Vec3(speed * 0.05, 0, 0));
  const NodeWeights expected = block.hold(0.013 + speed * 0.15).moves;
  EXPECT_TRUE(std::equal(expected.node.begin(), expected.node.begin() + 3, holds[0].moves.node.begin()));
  const std::optional<State> ahead = simulation.foresee(0.05, std::vector(1, holds));
  ASSERT_TRUE(ahead);
  EXPECT_EQ(simulation.state(), now);  // it only looks
  EXPECT_DOUBLE_EQ(ahead->t, now.t + 0.05);
  drag_to(0.15);
  const VectorX& later = simulation.state().x;
  EXPECT_LE((ahead->x - later).norm(), 0.25 * (now.x - later).norm());
}

/// The further away, the more steps it takes: each is straight, and the body is not.
TEST(LookAhead, FarAwayIsNearerInSteps) {
  const SlidBlock block;
  GlobalSimulation simulation(*block.model, make_integrator("implicit_euler"), 0.1);
  constexpr double kSpeed = 0.04, kFar = 0.3;
  const auto drag_to = [&](double t) {
    while (simulation.state().t < t - 1e-9) {
      const ContactHold hold = block.hold(0.013 + kSpeed * (simulation.state().t + 0.005));
      simulation.advance(simulation.state().t + 0.005, {}, {&hold, 1});
    }
  };
  drag_to(0.1);
  std::vector<std::optional<State>> ahead;
  for (const int steps : {1, 3}) {
    std::vector<std::vector<ContactHold>> stops;
    for (int i = 1; i <= steps; ++i) stops.push_back({block.hold(0.013 + kSpeed * (0.1 + kFar * i / steps))});
    ahead.push_back(simulation.foresee(kFar, stops));
    ASSERT_TRUE(ahead.back());
    EXPECT_DOUBLE_EQ(ahead.back()->t, 0.1 + kFar);
  }
  drag_to(0.1 + kFar);
  const VectorX& later = simulation.state().x;
  EXPECT_LE((ahead[1]->x - later).norm(), 0.7 * (ahead[0]->x - later).norm());
}

TEST(LookAhead, DoesNotPull) {
  const SlidBlock block;
  GlobalSimulation simulation(*block.model, make_integrator("implicit_euler"), 0.1);
  ContactHold hold = block.hold(0.02);
  simulation.advance(0.1, {}, {&hold, 1});
  hold.point.z() = 0.022;
  EXPECT_FALSE(simulation.foresee(0.05, std::vector(1, std::vector{hold})));
  EXPECT_FALSE(simulation.foresee(0.05, {}));
  GlobalSimulation limited(*block.model, make_integrator("symplectic_euler"), 0.1);
  const ContactHold pressed = block.hold(0.02);
  EXPECT_FALSE(limited.foresee(0.05, std::vector(1, std::vector{pressed})));
}

/// Springs under a local model that comes one interval late: the force errors without and with looking ahead.
TEST(LookAhead, BringsTheForceNearerToTheReference) {
  Scene scene = small_scene();
  scene.duration = 0.45;
  scene.global.rate_hz = 60;
  scene.global.early_refresh = false;
  scene.link.latency_ms = 1000 / scene.global.rate_hz;
  std::optional<Reference> reference;
  double error[2] = {};
  for (const bool look_ahead : {false, true}) {
    scene.global.look_ahead = look_ahead;
    Session session(scene);
    const SessionResult run = session.run();
    if (!reference) reference = run_reference(session, tool_paths(run), {.rate_hz = scene.local.rate_hz});
    EXPECT_EQ(run.refresh.looked_ahead > 5, look_ahead) << run.refresh.looked_ahead;
    error[look_ahead] = compare_forces(tick_forces(run.tools[0].frames), *reference).force_error;
  }
  EXPECT_LT(error[1], 0.85 * error[0]) << error[0];
}

}  // namespace
}  // namespace kt
