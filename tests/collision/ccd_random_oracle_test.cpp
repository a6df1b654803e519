// Time of impact against 113-bit arithmetic over random motions: never missed, never late, and early by no more than
// rounding and resolution allow.
#include <gtest/gtest.h>

#include <random>

#include "collision/impact/tool_impact.hpp"
#include "tests/support/collision_oracle.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

/// Every vertex and the tool move at random by about `motion`; thin: the triangle is a sliver, down to 1e-9.
CollisionQuery random_query(Sample& s, double motion, bool thin) {
  CollisionQuery q;
  q.tool_t0 = 0.5 * s.cube();
  q.tool_t1 = q.tool_t0 + motion * s.cube();
  for (int i = 0; i < 3; ++i) q.triangle_t0[i] = s.cube();
  const double width = thin ? std::pow(10, s.uniform(-9, -1)) : 1;
  if (thin)
    q.triangle_t0[2] = q.triangle_t0[0] + s.uniform(0, 1) * (q.triangle_t0[1] - q.triangle_t0[0]) + width * s.cube();
  const Vec3 together = motion * s.cube();
  for (int i = 0; i < 3; ++i) q.triangle_t1[i] = q.triangle_t0[i] + together + width * motion * s.cube();
  if (thin) {  // aimed at it
    const double w = s.uniform(0, 1);
    q.tool_t1 = w * q.triangle_t1[0] + (1 - w) * q.triangle_t1[1] + width * s.cube();
  }
  return q;
}

std::optional<Contact> impact(const CollisionQuery& q, double radius) {
  const ToolShape tool{radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, radius};
  return find_triangle_impact(tool, {q.tool_t0, q.tool_t1}, q.triangle_t0, q.triangle_t1);
}

double speed(const CollisionQuery& q) {
  double out = 0;
  for (int i = 0; i < 3; ++i) out = std::max(out, (q.triangle_t1[i] - q.triangle_t0[i] - q.tool_t1 + q.tool_t0).norm());
  return out;
}

// What separates tool and triangle at the time of impact at most: the rounding allowance of tool_impact.cpp, twice
// (coordinates relative to the tool stay below 8), and the way made during one resolution of the step.
double allowed_gap(const CollisionQuery& q) { return 2 * 128 * 0x1p-53 * 8 + speed(q) * 0x1p-42; }

struct Count {
  int hits = 0, truths = 0, ambiguous = 0, unexpected = 0;
  double earliest = 0, largest_gap = 0;
};

void report(const char* name, int queries, const Count& c) {
  std::printf(
      "%s: %d queries, %d collide, %d hits, %d ambiguous, %d hits without a crossing, earliest %.2g of the "
      "step, apart by at most %.2g of the allowance\n",
      name, queries, c.truths, c.hits, c.ambiguous, c.unexpected, c.earliest, c.largest_gap);
}

void compare(const CollisionQuery& q, double radius, const std::optional<ExactImpact>& truth, Count& count) {
  const auto hit = impact(q, radius);
  if (hit) {
    const double gap = exact_distance(q, hit->toi) - radius;
    ++count.hits;
    EXPECT_NEAR(std::abs(hit->gap), gap, allowed_gap(q));
    if (hit->gap >= 0) {
      count.largest_gap = std::max(count.largest_gap, gap / allowed_gap(q));
      EXPECT_LE(gap, allowed_gap(q));
    } else {
      EXPECT_EQ(hit->toi, 0);  // started a little inside: resting on the surface
    }
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-14);
  }
  if (truth && truth->ambiguous) {
    ++count.ambiguous;
    return;
  }
  if (hit && !truth) ++count.unexpected;  // closer than the allowance is contact
  if (!truth) return;
  ++count.truths;
  ASSERT_TRUE(hit);
  EXPECT_LE(hit->toi, truth->toi);
  count.earliest = std::max(count.earliest, hit->gap >= 0 ? truth->toi - hit->toi : 0);
}

void run_points(const char* name, unsigned seed, double motion, bool thin, int queries) {
  Sample s{std::mt19937_64(seed)};
  Count count;
  for (int i = 0; i < queries; ++i) {
    const CollisionQuery q = random_query(s, motion, thin);
    compare(q, 0, exact_point_impact(q), count);
    if (testing::Test::HasFailure()) FAIL() << name << " " << i;
  }
  report(name, queries, count);
  EXPECT_GT(count.truths, queries / 100);
}

TEST(PointTriangleToi, IsTheFirstRootOfTheCubicFromOutside) {
  run_points("points, slow", 1, 0.3, false, 100000);
  run_points("points", 2, 2, false, 100000);
}

TEST(PointTriangleToi, SliversAreNotMissed) { run_points("points, slivers", 3, 1, true, 100000); }

TEST(SphereTriangleToi, IsTheFirstTouch) {
  Sample s{std::mt19937_64(4)};
  Count count;
  const int queries = 3000;
  for (int i = 0; i < queries; ++i) {
    const CollisionQuery q = random_query(s, s.uniform(0, 1) < 0.5 ? 0.3 : 2, s.uniform(0, 1) < 0.3);
    const double radius = s.uniform(0.02, 0.5);
    if (exact_distance(q, 0) <= radius * 1.001) continue;
    const auto truth = exact_sphere_impact(q, radius);
    const auto other_side = impact(reversed(q), radius);
    // Seen from behind a face, a touch is none: one of the two sides must see it.
    const auto hit = impact(q, radius);
    const bool from_front = hit && (!other_side || hit->toi <= other_side->toi);
    compare(from_front || !truth ? q : reversed(q), radius, truth, count);
    if (HasFailure()) FAIL() << i;
  }
  report("spheres", queries, count);
  EXPECT_GT(count.truths, queries / 10);
}

}  // namespace
}  // namespace kt
