// What the surface follows of a ball on a path: by hand on a plane, and against the closest of all triangles.
#include "haptics/options/band_powers.hpp"
#include "haptics/setup/path_excitation.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "collision/shape/closest_point.hpp"
#include "core/body/mesh.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

constexpr double kToolRadius = 0.004, kToolMu = 0.5;

struct Block {
  Mesh mesh = kuhn_block(8, 8, 2, 0.01);
  Surface surface = make_surface(mesh);
  double top = 0.02;
  FollowedMotion motion() const { return {surface, mesh.x, kToolRadius, kToolMu}; }
  Vec3 at(double x, double depth) const { return {x, 0.043, top + kToolRadius - depth}; }
};

TEST(FollowedMotion, IsHowDeepTheBallIs) {
  const Block b;
  FollowedMotion m = b.motion();
  EXPECT_EQ(m.move_to(b.at(0.03, -0.05)), Vec3(0, 0, 0)) << "far above";
  EXPECT_EQ(m.move_to(b.at(0.03, -1e-5)), Vec3(0, 0, 0));
  EXPECT_NEAR((m.move_to(b.at(0.03, 0.001)) - Vec3(0, 0, -0.001)).norm(), 0, 1e-12);
  EXPECT_NEAR((m.move_to(b.at(0.03, 0.006)) - Vec3(0, 0, -0.006)).norm(), 0, 1e-12) << "its centre is inside";
  EXPECT_EQ(m.move_to(b.at(0.03, -0.001)), Vec3(0, 0, 0));
}

TEST(FollowedMotion, SticksUntilFrictionLetsItSlip) {
  const Block b;
  FollowedMotion m = b.motion();
  m.move_to(b.at(0.02, 0.002));
  EXPECT_NEAR((m.move_to(b.at(0.0205, 0.002)) - Vec3(5e-4, 0, -0.002)).norm(), 0, 1e-12) << "sticks";
  EXPECT_NEAR((m.move_to(b.at(0.03, 0.002)) - Vec3(kToolMu * 0.002, 0, -0.002)).norm(), 0, 1e-12) << "slips";
  EXPECT_NEAR((m.move_to(b.at(0.0295, 0.002)) - Vec3(kToolMu * 0.002 - 5e-4, 0, -0.002)).norm(), 0, 1e-12)
      << "and back";
}

TEST(FollowedMotion, FindsTheClosestOfAllTriangles) {
  const Block b;
  FollowedMotion m = b.motion();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  Vec3 place(0.04, 0.04, 0.03);
  for (int i = 0; i < 400; ++i) {
    place += 2e-3 * Vec3(any(random), any(random), any(random));
    place.z() += 0.1 * (0.022 - place.z());
    double nearest = 1;
    for (const Triangle& t : b.surface.triangles)
      nearest = std::min(
          nearest, closest_point_on_triangle(place, node(b.mesh.x, t[0]), node(b.mesh.x, t[1]), node(b.mesh.x, t[2]))
                       .distance_sq);
    const bool is_inside = (place.array() > 0).all() && (place.head<2>().array() < 0.08).all() && place.z() < b.top;
    const double depth = std::max(0.0, kToolRadius - (is_inside ? -1 : 1) * std::sqrt(nearest));
    const Vec3 u = m.move_to(place);
    const double tangential = kToolMu * depth;  // at most
    EXPECT_GE(u.norm(), depth - 1e-12);
    EXPECT_LE(u.norm(), std::hypot(depth, tangential) + 1e-12);
  }
}

TEST(PathPowers, OfAnEasyDragAreOfLowRates) {
  const Block b;
  const std::vector<TimedPoint> slow{{0, b.at(0.02, -0.002)}, {0.5, b.at(0.02, 0.002)}, {1.5, b.at(0.06, 0.002)}};
  const BandPowers p = path_powers(slow, b.motion(), 1000, 1 / 30.0);
  const double deep = 4e-6 * (1 + kToolMu * kToolMu);
  EXPECT_GT(p.total, 0.6 * deep);
  EXPECT_LT(p.total, deep);
  EXPECT_LT(p.changing[5], 1e-5 * p.total);
  std::vector<TimedPoint> shaking = slow;  // by 0.2 mm at 100 Hz, from 0.5 s on
  for (int i = 0; i < 1000; ++i)
    shaking.push_back({1.5 + 0.001 * (i + 1), b.at(0.06, 0.002 + 2e-4 * std::sin(0.2 * std::numbers::pi * (i + 1)))});
  const BandPowers q = path_powers(shaking, b.motion(), 1000, 1 / 30.0);
  const double swing = 0.5 * 4e-8 * (1 / 2.5), in_its_band = 0.8 - 0.2;  // of a Butterworth filter from 70.7 to 141 Hz
  EXPECT_NEAR(q.changing[4], in_its_band * swing, 0.05 * swing);
}

}  // namespace
}  // namespace kt
