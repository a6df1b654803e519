// Closest point of a triangle against 113-bit arithmetic, from fat triangles to ones that are all rounding.
#include "collision/shape/closest_point.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/collision_oracle.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

using Feature = ClosestPoint::Feature;

// Of the largest coordinate. Rounding the weights, the point and the difference: some 10 units of 1.1e-16.
constexpr double kRoundoff = 16 * 0x1p-53;

double largest_coordinate(const Vec3& p, const Vec3 (&v)[3]) {
  return std::max({p.lpNorm<Eigen::Infinity>(), v[0].lpNorm<Eigen::Infinity>(), v[1].lpNorm<Eigen::Infinity>(),
                   v[2].lpNorm<Eigen::Infinity>()});
}

void expect_closest(const Vec3& p, const Vec3 (&v)[3]) {
  const ClosestPoint at = closest_point_on_triangle(p, v[0], v[1], v[2]);
  const double size = largest_coordinate(p, v);
  EXPECT_NEAR(std::sqrt(at.distance_sq), exact_distance(p, v), kRoundoff * size);
  EXPECT_GE(at.bary.minCoeff(), 0);
  EXPECT_NEAR(at.bary.sum(), 1, kRoundoff);
  const Vec3 point = at.bary[0] * v[0] + at.bary[1] * v[1] + at.bary[2] * v[2];
  EXPECT_EQ(point, at.point);
  const auto zeros = (at.bary.array() == 0).count();
  EXPECT_EQ(zeros, at.feature == Feature::face ? 0 : at.feature == Feature::edge ? 1 : 2);
  if (at.feature == Feature::edge) {
    EXPECT_EQ(at.bary[(at.feature_index + 2) % 3], 0);
  }
  if (at.feature == Feature::vertex) {
    EXPECT_EQ(at.bary[at.feature_index], 1);
  }
}

TEST(ClosestPoint, DistanceIsRightForEveryShape) {
  Sample s{std::mt19937_64(7)};
  for (int i = 0; i < 40000; ++i) {
    // The third vertex lies off the line of the first two by 1 down to 1e-17, the point off the plane likewise.
    const Vec3 a = s.cube(), b = s.uniform(0, 1) < 0.3 ? Vec3(a + 1e-6 * s.cube()) : s.cube();
    const Vec3 c = a + s.uniform(-1.5, 1.5) * (b - a) + std::pow(10, s.uniform(-17, 0)) * s.cube();
    const Vec3 p = a + s.uniform(-0.5, 1.5) * (b - a) + s.uniform(-0.5, 1.5) * (c - a) +
                   std::pow(10, s.uniform(-17, 0.5)) * s.cube();
    const Vec3 v[3] = {a, b, c};
    const auto turn = static_cast<int>(s.random() % 3);
    const Vec3 turned[3] = {v[turn], v[(turn + 1) % 3], v[(turn + 2) % 3]};
    expect_closest(p, turned);
    if (HasFailure()) FAIL() << "sample " << i;
  }
}

TEST(ClosestPoint, TrianglesAgreeOnTheEdgeTheyShareBitForBit) {
  Sample s{std::mt19937_64(8)};
  int edges = 0, vertices = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 a = s.cube(), b = s.cube(), c = s.cube(), d = s.cube();
    // Above a ridge; both triangles run through the edge in opposite directions and start anywhere.
    const Vec3 p = a + s.uniform(-0.2, 1.2) * (b - a) + s.cube();
    const Vec3 v[3] = {a, b, c}, w[3] = {b, a, d};
    const auto turn = [&] { return static_cast<std::size_t>(s.random() % 3); };
    const auto at = [&](const Vec3(&x)[3], std::size_t k) {
      return closest_point_on_triangle(p, x[k], x[(k + 1) % 3], x[(k + 2) % 3]);
    };
    const std::size_t kv = turn(), kw = turn();
    const ClosestPoint one = at(v, kv), other = at(w, kw);
    const auto on_edge = [](const ClosestPoint& found, std::size_t k) {  // none of the vertex opposite
      return found.bary[static_cast<Eigen::Index>((2 + 3 - k) % 3)] == 0 && found.feature != Feature::face;
    };
    if (!on_edge(one, kv) || !on_edge(other, kw) || one.feature != other.feature) continue;
    if (one.feature == Feature::vertex && one.point != other.point) continue;  // nearer to a, or to b, for each
    ++(one.feature == Feature::edge ? edges : vertices);
    ASSERT_EQ(one.point, other.point) << "sample " << i;
    ASSERT_EQ(one.distance_sq, other.distance_sq);
    ASSERT_EQ(at(v, turn()).distance_sq, one.distance_sq) << "the same triangle from another corner";
  }
  EXPECT_GT(edges, 5000);
  EXPECT_GT(vertices, 2000);
}

TEST(ClosestPoint, ReachesEveryFeature) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto feature = [&](double x, double y) {
    const ClosestPoint at = closest_point_on_triangle({x, y, 0.5}, a, b, c);
    return std::pair(at.feature, at.feature_index);
  };
  EXPECT_EQ(feature(0.2, 0.3), std::pair(Feature::face, 0));
  EXPECT_EQ(feature(0.5, -1), std::pair(Feature::edge, 0));
  EXPECT_EQ(feature(1, 1), std::pair(Feature::edge, 1));
  EXPECT_EQ(feature(-1, 0.5), std::pair(Feature::edge, 2));
  EXPECT_EQ(feature(-1, -1), std::pair(Feature::vertex, 0));
  EXPECT_EQ(feature(3, -0.5), std::pair(Feature::vertex, 1));
  EXPECT_EQ(feature(-0.5, 3), std::pair(Feature::vertex, 2));
}

TEST(ClosestPoint, DegenerateTrianglesAreTheirEdges) {
  const Vec3 a(0.1, 0.2, 0.3), b(0.7, -0.2, 0.9), middle = 0.5 * (a + b), p(0.3, 0.5, -0.4);
  for (const auto& v : {std::array{a, a, a}, {a, a, b}, {a, b, a}, {b, a, a}, {a, middle, b}, {b, a, middle}}) {
    const Vec3 triangle[3] = {v[0], v[1], v[2]};
    expect_closest(p, triangle);
    expect_closest(a, triangle);
    expect_closest(middle, triangle);
  }
}

}  // namespace
}  // namespace kt
