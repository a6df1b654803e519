// Capsules and triangles of mesh tools against moving triangles: dense sampling, and spheres as the limit.
#include "collision/impact/hull_impact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/impact/tool_impact.hpp"
#include "collision/shape/closest_point.hpp"

namespace kt {
namespace {

struct Random {
  std::mt19937_64 engine;
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; }
  Vec3 point(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
};

struct Case {
  MovingHull hull;
  Vec3 t0[3], t1[3];
};

/// Distance between segment or triangle and triangle at time t, by a search that shares no code with the engine:
/// alternating projections between the two convex sets, from all corners.
double distance_at(const Case& c, double t) {
  using Point = Eigen::Matrix<long double, 3, 1>;
  std::vector<Point> a, b;
  for (int i = 0; i < c.hull.corners; ++i)
    a.push_back((c.hull.x_t0[i].cast<long double>() * (1 - t) + c.hull.x_t1[i].cast<long double>() * t).eval());
  for (int i = 0; i < 3; ++i)
    b.push_back((c.t0[i].cast<long double>() * (1 - t) + c.t1[i].cast<long double>() * t).eval());
  // Minkowski difference: the least |sum l_k (a_i - b_j)|, by Wolfe-like Frank-Wolfe with away steps is slow; the exact
  // minimum is at a face of the polytope of nine points, and every such face is spanned by at most three of them.
  std::vector<Point> d;
  for (const Point& x : a)
    for (const Point& y : b) d.push_back(x - y);
  long double best = 1e300L;
  const auto inside = [&](const Point& p) {  // p is the candidate's nearest point: optimal when it supports the set
    for (const Point& q : d)
      if (p.dot(q) < p.squaredNorm() - 1e-15L * std::max(1.0L, p.squaredNorm())) return false;
    return true;
  };
  const auto consider = [&](const Point& p) {
    if (inside(p)) best = std::min(best, p.norm());
  };
  const std::size_t n = d.size();
  for (std::size_t i = 0; i < n; ++i) {
    consider(d[i]);
    for (std::size_t j = i + 1; j < n; ++j) {
      const Point u = d[j] - d[i];
      const long double s = -u.dot(d[i]) / u.squaredNorm();
      if (s > 0 && s < 1) consider(d[i] + s * u);
      for (std::size_t k = j + 1; k < n; ++k) {
        const Point normal = u.cross((d[k] - d[i]).eval());
        const long double length_sq = normal.squaredNorm();
        if (!(length_sq > 0)) continue;
        const Point foot = normal * (normal.dot(d[i]) / length_sq);
        const auto side = [&](const Point& p, const Point& q) {
          return (q - p).cross((foot - p).eval()).dot(normal) >= 0;
        };
        if (side(d[i], d[j]) && side(d[j], d[k]) && side(d[k], d[i])) consider(foot);
      }
    }
  }
  return best > 1e299L ? 0 : static_cast<double>(best);
}

Case random_case(Random& random, int corners, double radius) {
  Case c;
  c.hull.corners = corners;
  c.hull.radius = radius;
  const Vec3 shift = random.point(0.6);
  for (int i = 0; i < corners; ++i) {
    c.hull.x_t0[i] = Vec3(0, 0, 1.2) + random.point(0.5);
    c.hull.x_t1[i] = c.hull.x_t0[i] + Vec3(0, 0, -1.5) + shift + random.point(0.2);
  }
  for (int i = 0; i < 3; ++i) {
    c.t0[i] = random.point(0.7);
    c.t1[i] = c.t0[i] + random.point(0.3);
  }
  return c;
}

class HullImpact : public testing::TestWithParam<std::pair<int, double>> {};

TEST_P(HullImpact, IsNeverMissedAndNeverLate) {
  const auto [corners, radius] = GetParam();
  Random random{std::mt19937_64(1)};
  int hits = 0, judged = 0;
  double largest_gap = 0;
  for (int i = 0; i < 400; ++i) {
    const Case c = random_case(random, corners, radius);
    if (distance_at(c, 0) <= radius + 1e-9) continue;
    ++judged;
    // From either side: the first of the triangle's and of that of its back.
    auto hit = find_hull_impact(c.hull, c.t0, c.t1);
    const Vec3 back_t0[3] = {c.t0[0], c.t0[2], c.t0[1]}, back_t1[3] = {c.t1[0], c.t1[2], c.t1[1]};
    const auto back = find_hull_impact(c.hull, back_t0, back_t1);
    if (back && (!hit || back->toi < hit->toi)) hit = back;
    const double until = hit ? hit->toi : 1;
    // Apart at every time before: a late time would be seen as contact.
    for (int k = 0; k <= 40; ++k) {
      const double t = until * k / 40.0;
      ASSERT_GE(distance_at(c, t) - radius, -1e-11) << "case " << i << " t " << t << " of " << until;
    }
    if (!hit) continue;
    ++hits;
    largest_gap = std::max(largest_gap, std::abs(distance_at(c, hit->toi) - radius));
    EXPECT_NEAR(hit->bary.sum(), 1, 1e-12);
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
  }
  EXPECT_GT(hits, 80);
  EXPECT_GT(judged, 200);
  EXPECT_LT(largest_gap, 1e-10);
  std::printf("corners %d radius %g: %d judged, %d hits, largest gap at the hit %.1e\n", corners, radius, judged, hits,
              largest_gap);
}

INSTANTIATE_TEST_SUITE_P(Shapes, HullImpact,
                         testing::Values(std::pair{1, 0.1}, std::pair{2, 0.05}, std::pair{2, 1e-6}, std::pair{3, 0.0},
                                         std::pair{3, 0.01}),
                         [](const auto& p) {
                           return "corners" + std::to_string(p.param.first) + "_" + std::to_string(p.index);
                         });

TEST(HullImpactOf, ASphereIsThatOfTheSphere) {
  Random random{std::mt19937_64(2)};
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    Case c = random_case(random, 1, 0.1);
    const auto hull = find_hull_impact(c.hull, c.t0, c.t1);
    const auto sphere =
        find_triangle_impact({ToolShape::Kind::sphere, 0.1}, {c.hull.x_t0[0], c.hull.x_t1[0]}, c.t0, c.t1);
    ASSERT_EQ(hull.has_value(), sphere.has_value()) << i;
    if (!hull) continue;
    ++hits;
    ASSERT_NEAR(hull->toi, sphere->toi, 1e-9) << i;
  }
  EXPECT_GT(hits, 3000);
}

/// A capsule along x, 4 mm above the plane z = 0, its radius 4 mm.
Case lying(const Vec3& velocity_0, const Vec3& velocity_1) {
  Case c;
  c.hull.corners = 2;
  c.hull.radius = 0.004;
  c.hull.x_t0[0] = Vec3(-0.01, 0, 0.004);
  c.hull.x_t0[1] = Vec3(0.01, 0, 0.004);
  c.hull.x_t1[0] = c.hull.x_t0[0] + velocity_0;
  c.hull.x_t1[1] = c.hull.x_t0[1] + velocity_1;
  const Vec3 corners[3] = {{-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0, 0.1, 0}};
  for (int i = 0; i < 3; ++i) c.t0[i] = c.t1[i] = corners[i];
  return c;
}

TEST(HullImpactOf, ALyingCapsule) {
  const Vec3 up(0, 0, 1e-3), down = -up, zero = Vec3::Zero(), along(1e-3, 0, 0);
  const auto hit = [](const Case& c) { return find_hull_impact(c.hull, c.t0, c.t1); };
  EXPECT_FALSE(hit(lying(up, up)));  // no lock when it leaves
  EXPECT_FALSE(hit(lying(along, along)));
  EXPECT_FALSE(hit(lying(zero, zero)));
  ASSERT_TRUE(hit(lying(down, down)));
  EXPECT_EQ(hit(lying(down, down))->toi, 0);
  for (const Case& tilting : {lying(up, down), lying(down, up), lying(zero, down)}) {
    ASSERT_TRUE(hit(tilting));  // it lifts at one end and sinks at the other
    EXPECT_EQ(hit(tilting)->toi, 0);
    EXPECT_NEAR((hit(tilting)->normal - Vec3::UnitZ()).norm(), 0, 1e-9);
  }
  Case below = lying(up, up);  // from within: it passes out
  for (int i = 0; i < 2; ++i) below.hull.x_t0[i].z() = -0.006, below.hull.x_t1[i].z() = 0.006;
  EXPECT_FALSE(hit(below));
}

TEST(HullImpactOf, NumbersThatAreNotFinite) {
  Case c = lying(-Vec3::UnitZ(), -Vec3::UnitZ());
  c.hull.x_t1[1].y() = std::nan("");
  EXPECT_FALSE(find_hull_impact(c.hull, c.t0, c.t1));
}

TEST(Sagitta, BoundsTheArcOfATurningPoint) {
  EXPECT_EQ(sagitta(0.02, 0), 0);
  for (double angle : {1e-3, 0.1, 1.0, 3.0}) {
    double most = 0;
    for (int k = 0; k <= 1000; ++k) {
      const double t = k / 1000.0;
      const Vec3 arc(0.02 * std::cos(t * angle), 0.02 * std::sin(t * angle), 0);
      const Vec3 line = (1 - t) * Vec3(0.02, 0, 0) + t * Vec3(0.02 * std::cos(angle), 0.02 * std::sin(angle), 0);
      most = std::max(most, (arc - line).norm());
    }
    EXPECT_LE(most, sagitta(0.02, angle) * (1 + 1e-7)) << angle;
  }
}

}  // namespace
}  // namespace kt
