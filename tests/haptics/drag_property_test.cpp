// Whole sessions over random drags on the bodies of meshes/: what must hold whatever the path.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"

namespace kt {
namespace {

struct Place {
  const char* mesh;
  double layer;               // [m] of the inner layer; 0: tetrahedra
  double depth;               // [m]
  const char* material = "";  // empty: springs
};

class RandomDrags : public testing::TestWithParam<Place> {};
INSTANTIATE_TEST_SUITE_P(Meshes, RandomDrags,
                         testing::Values(Place{"block.msh", 0, 0.002}, Place{"slab_coarse.off", 0, 0.002},
                                         Place{"sphere.off", 0.008, 0.002}, Place{"organ.off", 0.006, 0.002},
                                         Place{"torus.off", 0.005, 0.0015}, Place{"block.msh", 0, 0.002, "linear"},
                                         Place{"block.msh", 0, 0.002, "corotational"},
                                         Place{"block.msh", 0, 0.002, "stvk"},
                                         Place{"block.msh", 0, 0.002, "neo_hookean"},
                                         Place{"organ.off", 0, 0.002, "neo_hookean"}),
                         [](const auto& place) {
                           const std::string mesh = place.param.mesh;
                           const std::string material = place.param.material;
                           return mesh.substr(0, mesh.find('.')) + (material.empty() ? "" : "_" + material);
                         });

TEST_P(RandomDrags, StayFiniteInTheConeAndOutside) {
  const std::string mesh = GetParam().mesh;
  if (!KT_WITH_TETGEN && GetParam().layer == 0 && mesh.ends_with(".off")) GTEST_SKIP() << "needs tetgen";
  std::mt19937 random(17);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  // The law does not see the material: one coefficient for each of these.
  const std::vector<double> coefficients =
      std::string(GetParam().material).empty() ? std::vector{0.0, 0.3, 1.0} : std::vector{0.3};
  for (const char* shape : {"sphere", "point"})
    for (const double mu : coefficients) {
      Scene scene;
      scene.duration = 0.4;
      scene.object.mesh = KT_SOURCE_DIR "/meshes/" + mesh;
      if (GetParam().layer > 0) scene.object.layers = SceneLayers{1, GetParam().layer};
      if (const std::string material = GetParam().material; !material.empty()) {
        scene.object.model.type = "fem";
        scene.object.model.material = material;
      }
      scene.object.fixed.below->fraction = 0.3;
      scene.tool.shape = shape;
      const double angle = uniform(0, 6.28);
      scene.tool.path.press_drag = PressDrag{.at = {},
                                             .depth = GetParam().depth * uniform(0.5, 1),
                                             .press_time = uniform(0.05, 0.15),
                                             .direction = {std::cos(angle), std::sin(angle), 0},
                                             .speed = uniform(0.02, 0.1)};
      scene.contact.mu_static = scene.contact.mu_kinetic = mu;
      scene.collision.backend = "brute_force";
      if (mu != 0.3) scene.local.reducer = "condensed";  // certifying eight reducers takes longer than the drag
      SCOPED_TRACE(testing::Message() << shape << ", mu " << mu << ", direction " << angle);
      const SessionResult r = Session(scene).run();
      double pressed = 0, residual = 0;
      for (const LocalFrame& f : r.tools[0].frames) {
        residual = std::max(residual, f.residual);
        ASSERT_TRUE(f.force.allFinite());
        ASSERT_LE(f.cone_ratio, mu * (1 + 1e-9) + 1e-12);
        ASSERT_EQ(f.flags & kNotFinite, 0u);
        pressed = std::max(pressed, f.f_n);
      }
      EXPECT_GT(pressed, 1e-3);
      if (mu > 0) {
        EXPECT_GT(residual, 0) << "rounding at least: nobody reports it";
      }
      EXPECT_EQ(r.tools[0].missed_impacts, 0);
      EXPECT_LT(*std::ranges::max_element(r.tools[0].penetration), 1e-7);
    }
}

class SmoothDrags : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Meshes, SmoothDrags, testing::Values("block.msh", "sphere.off", "organ.off", "torus.off"),
                         [](const auto& mesh) {
                           return std::string(mesh.param).substr(0, std::string(mesh.param).find('.'));
                         });

/// The scene's path, the same way back.
std::vector<Waypoint> there_and_back(const Scene& scene) {
  std::vector<Waypoint> out;
  const Session session(scene);
  for (const TimedPoint& p : session.path()) out.push_back({p.t, p.x});
  for (auto k = static_cast<int>(out.size()) - 2; k >= 0; --k)
    out.push_back({2 * scene.duration - out[k].t, out[k].position});
  return out;
}

/// On Loop's surface: pressing, dragging, dragging back and lifting takes energy, and the tool stays outside.
TEST_P(SmoothDrags, StayOutsideAndGiveNoEnergy) {
  for (const char* shape : {"sphere", "point", "capsule"})
    for (const double mu : {0.0, 0.5}) {
      const bool is_slow = std::string(shape) == "capsule";  // as long as the others together
      if (is_slow && mu == 0) continue;
      Scene scene;
      scene.duration = 0.4;
      scene.object.mesh = KT_SOURCE_DIR "/meshes/" + std::string(GetParam());
      if (scene.object.mesh.ends_with(".off")) scene.object.layers = SceneLayers{1, 0.005};
      scene.object.fixed.below->fraction = 0.3;
      scene.tool.shape = shape;
      scene.tool.turn = {0, 1.57, 0};  // the capsule lies
      scene.tool.path.press_drag =
          PressDrag{.at = {}, .depth = 0.0015, .press_time = 0.1, .direction = {0.6, 0.8, 0}, .speed = 0.05};
      scene.contact.mu_static = scene.contact.mu_kinetic = mu;
      scene.contact.surface = "loop";
      scene.collision.backend = "brute_force";
      scene.local.reducer = "condensed";
      SCOPED_TRACE(testing::Message() << shape << ", mu " << mu);
      const SessionResult r = Session(scene).run();
      const ForceMetrics m = measure_forces(r.tools[0].frames, 0.15, 1e-3);
      EXPECT_GT(m.max_n, 1e-3);
      EXPECT_GT(m.energy_min, -1e-9);  // [J]
      EXPECT_LE(m.max_t_over_n, mu * (1 + 1e-9) + 1e-12);
      // From the end of the press on: a body may bounce off at the first touch.
      EXPECT_EQ(measure_forces(std::span<const LocalFrame>(r.tools[0].frames).subspan(100), 0.15, 1e-3).lost_contacts,
                0);
      EXPECT_EQ(r.tools[0].missed_impacts, 0);
      EXPECT_LT(*std::ranges::max_element(r.tools[0].penetration), 1e-6);  // [m]

      if (is_slow) continue;
      // There and back nothing is left in the body's springs: the work is what was lost.
      scene.tool.path.waypoints = there_and_back(scene);
      scene.tool.path.press_drag.reset();
      scene.duration *= 2;
      const SessionResult loop = Session(scene).run();
      double work = 0, largest = 0;
      for (std::size_t i = 1; i < loop.tools[0].frames.size(); ++i) {
        const Vec3 force = 0.5 * (loop.tools[0].frames[i].force + loop.tools[0].frames[i - 1].force);
        work -= force.dot(loop.tools[0].frames[i].pose.x - loop.tools[0].frames[i - 1].pose.x);
        largest = std::max(largest, work);
      }
      EXPECT_GT(work, 0.01 * largest) << "of " << largest << " J";
    }
}

/// A sphere smaller than the triangles that it is dragged over.
TEST(SmoothDrag, FeelsNoFoldsOfTheMesh) {
  if (!KT_WITH_TETGEN) GTEST_SKIP() << "needs tetgen";
  std::array<ForceMetrics, 2> metrics;
  for (const bool smooth : {false, true}) {
    Scene scene;
    scene.duration = 1;  // 40 mm: a sphere finds the deeper folds on some rows only
    scene.object.mesh = KT_SOURCE_DIR "/meshes/slab_coarse.off";
    scene.object.fixed.below->fraction = 0.05;
    scene.tool.shape = "sphere";
    scene.tool.radius = 0.002;
    scene.tool.path.press_drag =
        PressDrag{.at = {}, .depth = 0.003, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.05};
    scene.contact.mu_static = scene.contact.mu_kinetic = 0;
    scene.contact.surface = smooth ? "loop" : "flat";
    scene.local.reducer = "krylov";
    metrics[smooth] = measure_forces(Session(scene).run().tools[0].frames, 0.2, 1e-3);
  }
  EXPECT_LT(metrics[1].buzz, 0.005);
  EXPECT_LT(metrics[1].crossing_jump, 0.05);
  EXPECT_LT(metrics[1].crossing_jump, 0.4 * metrics[0].crossing_jump);
}

}  // namespace
}  // namespace kt
