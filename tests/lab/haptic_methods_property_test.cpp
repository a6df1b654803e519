// What every line of haptic_method.def must do in a whole session, this engine and the baselines alike.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "haptics/session/session.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/haptics_body.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

std::vector<std::string> methods() {
  std::vector<std::string> out;
  for (const BackendInfo& b : haptic_method_backends())
    if (b.available) out.push_back(b.name);
  return out;
}

/// Presses, drags, lets go.
Scene stroke(const std::string& method, const std::string& shape) {
  Scene scene = small_scene(shape);
  scene.duration = 0.4;
  scene.local.method = method;
  if (method == "legacy") scene.local.reducer = "wall";  // it knows no other
  const double top = 0.02 + (shape == "point" ? 0 : scene.tool.radius);
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = std::vector<Waypoint>{{0, {0.03, 0.026, top + 0.001}},
                                                    {0.1, {0.03, 0.026, top - 0.0015}},
                                                    {0.25, {0.036, 0.027, top - 0.0015}},
                                                    {0.3, {0.036, 0.027, top + 0.006}},
                                                    {0.4, {0.036, 0.027, top + 0.006}}};
  return scene;
}

class Method : public testing::TestWithParam<std::tuple<std::string, std::string>> {};
INSTANTIATE_TEST_SUITE_P(All, Method,
                         testing::Combine(testing::ValuesIn(methods()), testing::Values("point", "sphere")),
                         [](const auto& p) { return std::get<0>(p.param) + "_" + std::get<1>(p.param); });

TEST_P(Method, TouchesStaysInTheConeAndLetsGo) {
  const auto& [method, shape] = GetParam();
  const Scene scene = stroke(method, shape);
  SessionOptions options;
  options.count_allocations = [] { return thread_allocations(); };
  const SessionResult r = Session(scene).run(options);
  double pressed = 0, dragged = 0;
  for (const LocalFrame& f : r.tools[0].frames) {
    ASSERT_TRUE(f.force.allFinite()) << f.t;
    ASSERT_EQ(f.flags & kNotFinite, 0u) << f.t;
    ASSERT_LE(f.cone_ratio, scene.contact.mu_static * (1 + 1e-9)) << f.t;
    ASSERT_EQ(f.mode == ContactMode::free, f.force.isZero(0)) << f.t;
    if (f.t > 0.09 && f.t < 0.1) pressed = std::max(pressed, f.force.z());
    if (f.t > 0.15 && f.t < 0.25) dragged = std::min(dragged, f.force.x());
  }
  EXPECT_GT(pressed, 1e-3);
  EXPECT_LT(dragged, -1e-4) << "friction against the drag";
  EXPECT_EQ(r.tools[0].frames.back().mode, ContactMode::free);
  EXPECT_TRUE(r.tools[0].frames.back().force.isZero(0));
  EXPECT_EQ(r.allocations, 0);
}

TEST_P(Method, RepeatsItselfBitForBit) {
  const auto& [method, shape] = GetParam();
  Scene scene = stroke(method, shape);
  scene.link.latency_ms = 5;
  scene.link.loss = 0.2;
  Session session(scene);
  EXPECT_EQ(session.run().hash, session.run().hash);
}

TEST_P(Method, TakesUpABrokenPositionWithoutForceAndGoesOn) {
  const auto& [method, shape] = GetParam();
  static const SoftBlock body;
  HapticMethodOptions options;
  options.tools[0] = shape == "point" ? kPointTool : kSphereTool;
  options.friction = {0.5, 0.5};
  const Vec3 over(0.0412, 0.0263, 0.021 + options.tools[0].radius), in = over - Vec3(0, 0, 0.002);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    const auto tick = make_haptic_method(method, options);
    const auto refresh = [&](const Vec3& tool) {
      auto model = body.local_model(tool);
      model->tool = tool;
      tick->prepare_method_data(*model, 0.1);
      tick->adopt(std::move(model));
    };
    refresh(in);
    for (int i = 0; i < 50; ++i) tick->step({in, in});
    EXPECT_TRUE(tick->step({in, Vec3(bad, 0, 0)}).force.allFinite());
    EXPECT_TRUE(tick->step({Vec3(bad, 0, 0), over}).force.allFinite());
    EXPECT_TRUE(tick->step({over, over}).force.allFinite());
    EXPECT_TRUE(tick->model().state.q.allFinite());
    refresh(in);
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(tick->step({in, in}).force.allFinite());
    EXPECT_TRUE(tick->model().state.q.allFinite());
  }
}

TEST(MethodTable, IsWellFormedAndNamesTheKnown) {
  std::set<std::string> names;
  for (const BackendInfo& b : haptic_method_backends()) {
    EXPECT_TRUE(names.insert(b.name).second) << b.name << " is listed twice";
    EXPECT_FALSE(b.what.empty()) << b.name;
  }
  try {
    make_haptic_method("frozn", {});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean \"frozen\""), std::string::npos) << e.what();
  }
}

TEST(MethodTable, RefusesWhatDoesNotGoTogether) {
  for (const char* method : {"legacy", "frozen", "penalty"}) {
    HapticMethodOptions options;
    options.law = "paper_slide";
    EXPECT_THROW(make_haptic_method(method, options), InputError) << method;
  }
  HapticMethodOptions options;
  options.coupling.stiffness = 0;
  EXPECT_THROW(make_haptic_method("penalty", options), InputError);
  Scene scene = stroke("legacy", "point");
  scene.local.reducer = "full";
  EXPECT_THROW(Session{scene}, InputError) << "a wall is its framework";
}

}  // namespace
}  // namespace kt
