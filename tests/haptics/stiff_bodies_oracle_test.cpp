// Stiff bodies keep the tool outside as soft ones do, and linear ones push back by as much as they are stiffer.
#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

SessionResult pressed(double young) {
  Scene scene = small_scene();
  scene.duration = 0.15;
  scene.object.model.type = "fem";
  scene.object.model.material = "linear";
  scene.object.model.young = young;
  scene.object.model.damping.mass = 40;
  const Vec3 above(0.03, 0.026, 0.02 + scene.tool.radius + 1e-4), in = above - Vec3(0, 0, 1.1e-3);
  scene.tool.path = {.press_drag = {},
                     .waypoints = std::vector<Waypoint>{{0, above}, {0.1, in}, {scene.duration, in}},
                     .recording = {},
                     .hand = {},
                     .device = {}};
  return Session(scene).run();
}

/// Contact stiffness of 10 N/m to 1e10 N/m; where 1 kg in a tick (1e6 N/m) was as soft as it gets, that was felt from
/// 1e8 Pa on.
TEST(StiffBody, PushesBackByItsYoungsModulusAndKeepsTheToolOutside) {
  const double soft = pressed(1e5).tools[0].frames.back().f_n / 1e5;
  for (const double young : {1e8, 1e10, 1e13}) {
    const SessionResult run = pressed(young);
    EXPECT_NEAR(run.tools[0].frames.back().f_n / young / soft, 1, 0.02) << young;
    EXPECT_LT(*std::ranges::max_element(run.tools[0].penetration), 1e-8) << young;
    for (const LocalFrame& f : run.tools[0].frames) ASSERT_FALSE(f.flags & (kRigidContact | kNotFinite)) << young;
  }
}

// Softened for the ten thousandth of a tick that was left, the contact was told as one with a clamped part.
TEST(StiffBody, ATouchAtTheEndOfATickIsNoClampedPart) {
  Scene scene = small_scene();
  scene.duration = 0.02;
  scene.object.model.type = "fem";
  constexpr double kSpeed = 0.02, kTouches = 0.0109999;  // [m/s], [s]
  const Vec3 above(0.03, 0.026, 0.02 + scene.tool.radius + kSpeed * kTouches), down = kSpeed * Vec3::UnitZ();
  scene.tool.path = {.press_drag = {},
                     .waypoints = std::vector<Waypoint>{{0, above}, {scene.duration, above - scene.duration * down}},
                     .recording = {},
                     .hand = {},
                     .device = {}};
  const SessionResult run = Session(scene).run();
  EXPECT_GT(run.tools[0].frames[10].toi, 0.999);
  EXPECT_GT(run.tools[0].frames.back().f_n, 0);
  for (const LocalFrame& f : run.tools[0].frames) EXPECT_FALSE(f.flags & kRigidContact) << f.t;
}

}  // namespace
}  // namespace kt
