// Friction by place: the table of triangles, and what a tool feels that is dragged over a border.
#include "haptics/contact/scene_friction.hpp"

#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

TEST(SceneFriction, TheLastRegionThatHoldsATrianglesMiddleWins) {
  const Mesh mesh = kuhn_block(4, 4, 4, 0.01);
  const Surface surface = make_surface(mesh);
  ContactSettings contact;
  contact.stribeck = 0.1;
  contact.regions = {{{Vec3(-1, -1, -1), Vec3(0.02, 1, 1)}, 0.8, 0.7},
                     {{Vec3(-1, -1, 0.035), Vec3(1, 1, 1)}, 0.3, 0.2},
                     {{Vec3(2, 2, 2), Vec3(3, 3, 3)}, 9, 9}};
  std::vector<std::string> warnings;
  const SurfaceFriction friction = scene_friction(contact, surface, mesh.x, warnings);
  ASSERT_EQ(friction.of_triangle.size(), surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (int i : surface.triangles[t]) middle += node(mesh.x, i) / 3;
    const Friction expected = middle.z() >= 0.035  ? Friction{0.3, 0.2, 0.1}
                              : middle.x() <= 0.02 ? Friction{0.8, 0.7, 0.1}
                                                   : Friction{0.5, 0.5, 0.1};
    EXPECT_EQ(friction.at(static_cast<int>(t)), expected) << "triangle " << t;
  }
  EXPECT_EQ(friction.at(-1), friction.everywhere);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "contact.regions[2]: no surface triangle has its middle in the box");
}

TEST(SceneFriction, WithoutRegionsThereIsNoTable) {
  const Mesh mesh = kuhn_block(2, 2, 2, 0.01);
  std::vector<std::string> warnings;
  EXPECT_TRUE(scene_friction({}, make_surface(mesh), mesh.x, warnings).of_triangle.empty());
}

TEST(SceneFriction, ADragFromSmoothToRoughFeelsBoth) {
  for (const char* method : {"multirate", "frozen"}) {
    Scene scene = small_scene();
    scene.duration = 0.5;
    scene.local.method = method;
    scene.contact.mu_static = scene.contact.mu_kinetic = 0.2;
    scene.contact.regions = {{{Vec3(0.036, -1, -1), Vec3(1, 1, 1)}, 0.8, 0.8}};
    Session session(scene);
    const SessionResult r = session.run();
    int smooth = 0, rough = 0;
    for (const LocalFrame& f : r.tools[0].frames) {
      if (f.contacts != 1 || f.mode != ContactMode::frictional_slide) continue;
      const double mu = session.friction().at(f.triangle).mu_kinetic;
      ASSERT_NEAR(f.cone_ratio, mu, 1e-9) << method << ", t = " << f.t;
      ++(mu == 0.2 ? smooth : rough);
    }
    EXPECT_GT(smooth, 20) << method;
    EXPECT_GT(rough, 20) << method;
  }
}

}  // namespace
}  // namespace kt
