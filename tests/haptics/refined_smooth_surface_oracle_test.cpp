// Refined cells under Loop's smooth surface, through the whole engine: a drag over facets waves less, on a flat face
// nothing changes, no energy is made.
#include <gtest/gtest.h>

#include <cstdio>

#include "haptics/touch/touch.hpp"
#include "tests/support/drag_ripple.hpp"
#include "tests/support/fine_block.hpp"
#include "tests/support/hand_work.hpp"

namespace kt {
namespace {

/// A ball that is drawn over an arch of 50 mm, 1.5 mm deep everywhere; facets of 10 mm meet at 11 degrees.
/// @param to_and_fro  back on the same way, and let go
SessionResult drag_over_arch(const std::string& surface, double y = 0.028, double duration = 1.4,
                             bool to_and_fro = false) {
  constexpr double kOuter = 0.05;
  Mesh mesh = kuhn_block(10, 6, 2, 0.01);
  std::vector<int> inside;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 p = node(mesh.x, i);
    if (p.z() < 1e-9) inside.push_back(i);
    const double angle = (p.x() - 0.05) / kOuter, r = kOuter - 0.02 + p.z();
    node(mesh.x, i) = Vec3(r * std::sin(angle), p.y(), r * std::cos(angle));
  }
  Scene scene = scene_of({.duration = duration, .refine = "auto"});
  scene.object.fixed = {.below = {}, .box = {}, .nodes = inside};
  scene.contact.surface = surface;
  scene.tool.path.press_drag.reset();
  const auto at = [&](double angle, double height) {
    const double r = kOuter + kBallRadius + height;
    return Vec3(r * std::sin(angle), y, r * std::cos(angle));
  };
  std::vector<Waypoint> way{{0, at(-0.3, 1e-3)}, {0.3, at(-0.3, -1.5e-3)}};
  for (int i = 1; i <= 50; ++i) way.push_back({0.4 + 0.02 * i, at(-0.3 + 0.012 * i, -1.5e-3)});
  for (int i = 49; to_and_fro && i >= 0; --i) way.push_back({2.4 - 0.02 * i, at(-0.3 + 0.012 * i, -1.5e-3)});
  if (to_and_fro) way.push_back({2.6, at(-0.3, 1e-3)});
  scene.tool.path.waypoints = std::move(way);
  return Session(scene, std::move(mesh)).run();
}

/// Peak to peak over the mean, of two paths [-].
double ripple_of(const std::string& surface) {
  double sum = 0;
  for (const double y : {0.025, 0.028}) {
    const SessionResult r = drag_over_arch(surface, y);
    const DragRipple found = drag_ripple({r.tools[0].frames.begin(), r.tools[0].frames.end()}, 450);
    std::printf("%s: %.4f N, ripple %.1f %%, step %.1f %%\n", surface.c_str(), found.mean, 100 * found.peak_to_peak,
                100 * found.largest_step);
    EXPECT_LT(found.largest_step, 0.03);
    sum += found.peak_to_peak;
  }
  return sum / 2;
}

TEST(RefinedSmoothSurface, ADragOverFacetsWavesLess) {
  const double flat = ripple_of("flat"), smooth = ripple_of("loop");
  EXPECT_GT(flat, 0.1);
  EXPECT_LT(smooth, 0.5 * flat);
}

// The global step holds the body's own point where the tool holds the smooth surface's.
TEST(RefinedSmoothSurface, GlobalStepFindsTheForceOfTheTicks) {
  for (const char* surface : {"flat", "loop"}) {
    const SessionResult r = drag_over_arch(surface, 0.028, 0.4);
    ASSERT_FALSE(r.refresh.linearization_error.empty());
    EXPECT_LT(std::abs(r.refresh.linearization_error.back()), 0.02) << surface;
  }
}

// The surface turns with the body at each refresh: the hand gets nothing out of it.
TEST(RefinedSmoothSurface, GivesNoEnergyToAndFro) {
  const SessionResult r = drag_over_arch("loop", 0.028, 2.7, true);
  const auto& frames = r.tools[0].frames;
  const auto [given, most, dragged] = hand_work({frames.begin(), frames.end()}, 0.4, 2.4);
  EXPECT_GT(most, 4e-5) << "it was pressed in";
  EXPECT_GT(given, 0);
  EXPECT_GT(dragged, 0);
  EXPECT_EQ(frames.back().mode, ContactMode::free);
  EXPECT_EQ(r.tools[0].lost.free_ticks_inside, 0);
  EXPECT_LT(std::ranges::max(r.tools[0].penetration), 1e-6);
}

TEST(RefinedSmoothSurface, OnAFlatFaceTheForceIsTheSame) {
  Scene scene = scene_of({.speed = 0.02, .mu = 0.2});
  scene.contact.surface = "loop";
  const SessionResult smooth = Session(scene, block_of({})).run(), flat = run({.speed = 0.02, .mu = 0.2});
  const auto &a = smooth.tools[0].frames, &b = flat.tools[0].frames;
  ASSERT_GT(b.back().f_n, 0.05);
  for (std::size_t i = 0; i < b.size(); ++i) EXPECT_LT((a[i].force - b[i].force).norm(), 1e-6 * b.back().f_n) << i;
}

}  // namespace
}  // namespace kt
