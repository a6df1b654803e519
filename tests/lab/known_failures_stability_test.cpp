// Every known failure by name: where it fails, and that it does not fail silently. The maps show the whole region
// (docs/stability.md); here is one place on either side of each boundary.
#include <gtest/gtest.h>

#include "haptics/findings/run_findings.hpp"
#include "haptics/predict/predict_contact_method.hpp"
#include "haptics/predict/predict_degenerate_contact.hpp"
#include "haptics/predict/predict_elements.hpp"
#include "haptics/session/session.hpp"
#include "io/solid/tetrahedra_quality.hpp"
#include "lab/stability/runs/explicit_limit.hpp"
#include "lab/stability/runs/single_points.hpp"
#include "lab/stability/runs/sliver.hpp"
#include "lab/stability/runs/step_runs.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.01;  // [m]

bool holds(const std::vector<std::string>& lines, const std::string& words) {
  return std::ranges::any_of(lines, [&](const std::string& line) { return line.find(words) != line.npos; });
}

/// Of failures: that its cells are coarse for its tool is said of many a good scene.
std::vector<Prediction> failures_of(const Session& session) {
  std::vector<Prediction> out = session.predictions();
  std::erase_if(out, [](const Prediction& p) { return p.failure == "contact_width"; });
  return out;
}

TEST(ExplicitStep, DivergesWhereTheFastestModeSaysAndIsPredicted) {
  for (const ModelChoice& choice : {ModelChoice{"msd", ""}, ModelChoice{"fem", "neo_hookean"}})
    for (double damping : {0.0, 2e-3}) {
      const auto model = clamped(choice, kuhn_block(2, 2, 2, kCell), {.damping_stiffness = damping});
      StabilityMap map;
      const RayResult ray = find_explicit_limit(*model, "symplectic_euler", "s", 0);
      map.boundaries = ray.boundaries;
      EXPECT_LE(distance_from_theory(map, [](const std::string&) { return true; }), 0.02) << choice.name() << damping;
      const double limit = ray.boundaries[0].points[0].second;
      for (const MapPoint& p : ray.points) {
        EXPECT_EQ(p.verdict == MapVerdict::fails, p.y > limit) << p.y / limit;
        if (std::abs(p.y / limit - 1) > 0.02) {
          EXPECT_EQ(p.predicted_failure, p.y > limit) << p.y / limit;
        }
      }
    }
}

TEST(ExplicitStep, OfASceneTooStiffForItWarnsBeforeTheRunAndFlagsItsTicks) {
  Scene scene = small_scene();
  scene.object.model.young = 1e8;
  scene.local.integrator = "symplectic_euler";
  Session session(scene);
  const auto predicted = failures_of(session);
  ASSERT_EQ(predicted.size(), 1u);
  EXPECT_EQ(predicted[0].failure, "time_step");
  for (const char* words : {"local.integrator", "1 ms", "implicit_euler", "Hz"})
    EXPECT_NE(predicted[0].message().find(words), std::string::npos) << predicted[0].message();
  const SessionResult result = session.run();
  EXPECT_TRUE(holds(lines(all_findings(session, result)), "local.integrator symplectic_euler"));
  EXPECT_TRUE(
      std::ranges::any_of(result.tools[0].frames, [](const LocalFrame& f) { return (f.flags & kNotFinite) != 0; }));
  for (const LocalFrame& f : result.tools[0].frames) ASSERT_TRUE(f.force.allFinite());
}

TEST(Predictions, AreNoneForAGoodScene) { EXPECT_TRUE(failures_of(Session(small_scene())).empty()); }

TEST(ImplicitStep, DampsAndDelaysAsItsStabilityFunctionSays) {
  const auto model = clamped({"fem", "linear"}, kuhn_block(2, 2, 2, kCell), {});
  const Vibration slowest = slowest_vibration(*model);
  for (const char* name : {"implicit_euler", "newton_euler", "sdirk2", "implicit_midpoint"})
    for (double omega_h : {0.03, 0.3, 1.0, 30.0}) {
      const auto integrator = make_integrator(name);
      const StepRun run = run_vibration(*model, *integrator, slowest, 1e-4 * kCell / slowest.shape.maxCoeff(),
                                        omega_h / slowest.omega, 10);
      EXPECT_NEAR(run.period_error, theoretical_period_error(name, omega_h), 1e-3) << name << ' ' << omega_h;
      EXPECT_LE(run.growth, 1.001) << name << ' ' << omega_h;
    }
}

/// Deflection of a column of 2 x 2 x 6 cells under its weight, sideways [m].
double deflection(const std::string& element, double poisson) {
  ModelOptions options{.young = 1e5, .poisson = poisson, .element = element, .gravity = Vec3(0.1, 0, 0)};
  const auto model = clamped({"fem", "linear"}, kuhn_block(2, 2, 6, kCell), options);
  State state = rest_state(*model);
  make_integrator("quasistatic", {.solver = "direct"})->step(*model, VectorX::Zero(state.x.size()), 0, state);
  return (state.x - model->mesh().x).lpNorm<Eigen::Infinity>();
}

TEST(Locking, OfFourNodesNearIncompressibilityIsPredictedAndTenNodesCureIt) {
  EXPECT_GE(deflection("tet10", 0.4999) / deflection("tet4", 0.4999), 3);
  EXPECT_LE(deflection("tet10", 0.3) / deflection("tet4", 0.3), 2.2);
  EXPECT_NEAR(deflection("tet10", 0.4999) / deflection("tet10", 0.3), 1, 0.2);
  const auto model = clamped({"fem", "linear"}, kuhn_block(2, 2, 6, kCell), {});
  const auto prediction = predict_locking(*model, "tet4", 0.4999);
  ASSERT_TRUE(prediction);
  EXPECT_EQ(prediction->failure, "poisson");
  EXPECT_NE(prediction->message().find("tet10"), std::string::npos) << prediction->message();
  EXPECT_FALSE(predict_locking(*model, "tet10", 0.4999));
}

/// How far the farthest node is from its place, of the edge, a second after the block was turned inside out.
double left_of_inversion(const std::string& material) {
  const auto model =
      clamped({"fem", material}, kuhn_block(2, 2, 2, kCell), {.damping_mass = 5, .damping_stiffness = 2e-3});
  State state = rest_state(*model);
  for (int i = 0; i < model->mesh().num_nodes(); ++i) node(state.x, i).z() *= -0.5;
  state.x += shaken_positions(*model, 0.01 * kCell);
  const auto integrator = make_integrator("newton_euler", {.solver = "direct"});
  for (int i = 0; i < 100; ++i) integrator->step(*model, VectorX::Zero(state.x.size()), 0.02, state);
  return (state.x - model->mesh().x).lpNorm<Eigen::Infinity>() / (2 * kCell);
}

TEST(Springs, AreTooStiffNearIncompressibilityAndSayIt) {
  const auto tip = [](double poisson) {
    const auto model = clamped({"msd", ""}, kuhn_block(2, 2, 6, kCell),
                               {.young = 1e5, .poisson = poisson, .gravity = Vec3(0.1, 0, 0)});
    EXPECT_EQ(predict_locking(*model, "tet4", poisson).has_value(), poisson > 0.4) << poisson;
    State state = rest_state(*model);
    make_integrator("quasistatic", {.solver = "direct"})->step(*model, VectorX::Zero(state.x.size()), 0, state);
    return (state.x - model->mesh().x).lpNorm<Eigen::Infinity>();
  };
  EXPECT_LE(tip(0.49) / deflection("tet10", 0.49), 0.1);
  EXPECT_GE(tip(0.3) / deflection("tet10", 0.3), 0.67);
}

TEST(Inversion, OfStVenantKirchhoffStaysAndIsPredictedNeoHookeanComesBack) {
  EXPECT_GE(left_of_inversion("stvk"), 0.5);
  EXPECT_LE(left_of_inversion("neo_hookean"), 0.01);
  ASSERT_TRUE(predict_collapse("stvk", -0.5));
  EXPECT_NE(predict_collapse("stvk", -0.5)->message().find("neo_hookean"), std::string::npos);
  EXPECT_FALSE(predict_collapse("neo_hookean", -0.5));
  EXPECT_FALSE(predict_collapse("stvk", 0.5));
}

TEST(Sliver, HasTheAngleAskedForAndShortensExplicitStepsOnly) {
  double before = 0;
  for (double angle : {45.0, 1.0, 0.1}) {
    const Mesh mesh = block_with_sliver(3, kCell, angle);
    EXPECT_NEAR(tetrahedra_quality(mesh).dihedral_min / angle, 1, 1e-3);
    EXPECT_GT(tetrahedra_quality(mesh).volume_min, 0);
    const auto model = clamped({"fem", "neo_hookean"}, mesh, {});
    const double limit = make_integrator("symplectic_euler")->stable_step(fastest_mode(*model, rest_state(*model)));
    if (before > 0) {
      EXPECT_LE(limit, 0.5 * before) << angle;
    }
    before = limit;
    State start = rest_state(*model);
    start.x += shaken_positions(*model, 1e-5 * kCell);
    const auto implicit = make_integrator("implicit_euler");
    EXPECT_FALSE(run_steps(*model, *implicit, start, 0.01, 20, 10).diverged(10)) << angle;
  }
}

TEST(ToolInside, AtTheStartIsPredictedAndOutsideIsNot) {
  Scene scene = small_scene();
  Session outside(scene);
  const Vec3 above = outside.path().front().x;
  for (double depth : {0.0, 0.004}) {
    // The sphere's reference point `depth` below where it touches the top.
    scene.tool.path.press_drag.reset();
    const double top = bounds(outside.model().mesh()).max.z();
    const Vec3 at(above.x(), above.y(), top + scene.tool.radius - depth);
    scene.tool.path.waypoints = {{0, at}, {0.1, at}};
    const Session session(scene);
    const auto predicted = failures_of(session);
    ASSERT_EQ(predicted.size(), depth > 0 ? 1u : 0u) << depth;
    if (depth == 0) continue;
    EXPECT_EQ(predicted[0].failure, "degenerate_contact");
    EXPECT_NE(predicted[0].message().find("4 mm inside"), std::string::npos) << predicted[0].message();
  }
}

TEST(TriangleWithoutArea, IsPredicted) {
  VectorX x(12);
  x << 0, 0, 0, 1, 0, 0, 0.5, 0, 0, 0, 1, 0;
  ASSERT_TRUE(predict_flat_triangles(x, {{0, 1, 3}, {0, 1, 2}}));
  EXPECT_NE(predict_flat_triangles(x, {{0, 1, 2}})->message().find("object.repair"), std::string::npos);
  EXPECT_FALSE(predict_flat_triangles(x, {{0, 1, 3}}));
}

TEST(FastBall, GoesThroughFrozenPlanesBeyondItsOwnSizeATickAndIsPredicted) {
  for (const auto& [speed, fails] : {std::pair{1.5, false}, {3.0, true}}) {
    const MapPoint p = shoot_at_sheet("frozen", speed, 0.002);
    EXPECT_EQ(p.verdict == MapVerdict::fails, fails) << speed << ": " << p.why;
    EXPECT_EQ(p.predicted_failure, fails) << speed << ": " << p.prediction;
  }
  EXPECT_TRUE(shoot_at_sheet("legacy", 0.05, 0.002).predicted_failure);
}

TEST(FastBall, IsHeldByTheEnginesOwnMethodAtEverySpeedAndThickness) {
  for (double thickness : {0.0005, 0.002, 0.008})
    for (double speed : {0.5, 5.0, 10.0}) {
      const MapPoint p = shoot_at_sheet("multirate", speed, thickness);
      EXPECT_NE(p.verdict, MapVerdict::fails) << thickness << ' ' << speed << ": " << p.why;
      EXPECT_FALSE(p.predicted_failure) << p.prediction;
    }
}

TEST(LateModels, TurnTheForceAwayButNeverLoseContact) {
  EXPECT_EQ(drag_with_late_models(30, 10, 0).verdict, MapVerdict::works);
  for (double latency : {100.0, 500.0}) {
    const MapPoint p = drag_with_late_models(30, latency, 0.6);
    EXPECT_EQ(p.verdict, MapVerdict::degrades) << p.why;
    EXPECT_NE(p.why.find("patch's edge"), std::string::npos) << p.why;
  }
}

TEST(PenaltySpring, TooStiffForItsNodesChattersAndIsPredicted) {
  ToolMeeting meeting{.speed = 0.05, .drag = 0.05, .thickness = 0.01, .mass = 1e-4};
  Scene scene = small_scene();
  scene.local.method = "penalty";
  scene.contact.penalty.stiffness = 300;
  EXPECT_FALSE(predict_chatter(scene, meeting));
  scene.contact.penalty.stiffness = 500;
  ASSERT_TRUE(predict_chatter(scene, meeting));
  EXPECT_NE(predict_chatter(scene, meeting)->message().find("at most 400 N/m"), std::string::npos)
      << predict_chatter(scene, meeting)->message();
  scene.local.method = "multirate";
  EXPECT_FALSE(predict_chatter(scene, meeting));
}

TEST(ToolMeeting, KnowsSpeedAndThicknessWhereThePathGoesIn) {
  Scene scene = small_scene();
  scene.tool.path.press_drag.reset();
  const Bounds box = bounds(Session(small_scene()).model().mesh());
  const Vec3 middle = 0.5 * (box.min + box.max), up(0, 0, box.max.z() - middle.z() + 0.01);
  scene.tool.path.waypoints = {{0, middle + up}, {0.1, middle + up}, {0.2, middle}};
  const auto meeting = find_meeting(Session(scene));
  ASSERT_TRUE(meeting);
  EXPECT_NEAR(meeting->speed, up.z() / 0.1, 1e-9);
  EXPECT_NEAR(meeting->thickness, box.max.z() - box.min.z(), 1e-6);
  scene.tool.path.waypoints = {{0, middle + up}, {0.1, middle - up}};  // all the way through
  EXPECT_NEAR(find_meeting(Session(scene)).value().thickness, box.max.z() - box.min.z(), 1e-6);
  scene.tool.path.waypoints = {{0, middle + up}, {0.1, middle + 2 * up}};
  EXPECT_FALSE(find_meeting(Session(scene)));
}

}  // namespace
}  // namespace kt
