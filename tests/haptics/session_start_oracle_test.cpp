// Where a session starts: a body in its weight, a second tool beside the first.
#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/findings/run_findings.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

bool names(const std::vector<std::string>& warnings, const std::string& words) {
  return std::ranges::any_of(warnings, [&](const std::string& w) { return w.find(words) != w.npos; });
}

std::vector<std::string> warnings_of(Session& session) {
  std::atomic<bool> stop{true};
  SessionOptions options;
  options.stop = &stop;  // after a tick
  return lines(all_findings(session, session.run(options)));
}

Scene heavy(const std::string& type, double young) {
  Scene scene = small_scene();
  scene.object.model.type = type;
  scene.object.model.young = young;
  scene.object.gravity = {0, 0, -9.81};
  return scene;
}

TEST(Weight, ABodyThatBearsItHangsInIt) {
  for (const char* type : {"msd", "fem"}) {
    Session session(heavy(type, 1e4));
    const double sag = (session.model().mesh().x - session.start().x).lpNorm<Eigen::Infinity>();
    // A layer of 20 mm, glued to the table, in the middle: rho g H^2 / 2 over its constrained modulus, 13.5 kPa at a
    // Poisson ratio of 0.3. At a corner nothing holds it from the side: over Young's modulus.
    EXPECT_GT(sag, 1.0 * 1000 * 9.81 * 0.02 * 0.02 / 2 / 13.5e3) << type;
    EXPECT_LT(sag, 1.1 * 1000 * 9.81 * 0.02 * 0.02 / 2 / 10e3) << type;
    EXPECT_FALSE(names(warnings_of(session), "does not bear")) << type;
  }
}

TEST(Weight, ACollapseIsNoEquilibrium) {
  for (const char* type : {"msd", "fem"}) {
    Session session(heavy(type, 20));
    EXPECT_EQ(session.start().x, session.model().mesh().x) << type;
    const auto warnings = warnings_of(session);
    EXPECT_TRUE(names(warnings, "does not bear its own weight")) << type;
    EXPECT_TRUE(names(warnings, "raise object.model.young (20 Pa) to about 981 Pa")) << type;
  }
}

TEST(SecondTool, WithoutAPlaceOfItsOwnGoesBesideTheFirst) {
  Scene scene = small_scene();
  scene.tool.path.press_drag->at.reset();
  scene.second_tool = scene.tool;
  const SessionResult result = Session(scene).run();
  for (std::size_t i = 0; i < result.tools[0].frames.size(); ++i)
    ASSERT_GE((result.tools[0].frames[i].pose.x - result.tools[1].frames[i].pose.x).norm(),
              4 * scene.tool.radius - 1e-6);
  EXPECT_GT(result.tools[0].frames.back().f_n, 0);
  EXPECT_GT(result.tools[1].frames.back().f_n, 0);
}

TEST(SecondTool, InTheFirstOnesPlaceIsRefused) {
  Scene scene = small_scene();
  scene.second_tool = scene.tool;
  EXPECT_NE(message([&] { Session{scene}; }).find("second_tool.path: the tools are 0 mm apart at the start"),
            std::string::npos);
  scene.second_tool->path = {.press_drag = {},
                             .waypoints = std::vector<Waypoint>{{0, {0.06, 0.026, 0.03}}, {0.3, {0.03, 0.026, 0.03}}},
                             .recording = {},
                             .hand = {},
                             .device = {}};
  scene.tool.path = {.press_drag = {},
                     .waypoints = std::vector<Waypoint>{{0, {0.03, 0.026, 0.03}}, {0.3, {0.06, 0.026, 0.03}}},
                     .recording = {},
                     .hand = {},
                     .device = {}};
  Session crossing(scene);
  EXPECT_TRUE(names(warnings_of(crossing), "apart on their way"));
}

}  // namespace
}  // namespace kt
