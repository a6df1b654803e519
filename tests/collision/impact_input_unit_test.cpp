// What tools say of numbers that are none, or out of range: no contact, and never a contact that is not one.
#include <gtest/gtest.h>

#include <limits>

#include "collision/impact/feature_toi.hpp"
#include "collision/impact/hull_impact.hpp"
#include "collision/impact/tool_impact.hpp"

namespace kt {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

/// Downwards through the middle of a triangle at rest, all lengths times `scale`.
struct Shot {
  Vec3 from, to, triangle[3];
  double radius;

  explicit Shot(double scale, double of_radius = 0.1)
      : from(0.2 * scale, 0.2 * scale, scale),
        to(0.2 * scale, 0.2 * scale, -scale),
        triangle{Vec3(0, 0, 0), Vec3(scale, 0, 0), Vec3(0, scale, 0)},
        radius(of_radius * scale) {}

  std::optional<Contact> of_sphere() const {
    return find_triangle_impact({ToolShape::Kind::sphere, radius}, {from, to}, triangle, triangle);
  }
  std::optional<Contact> of_capsule() const {
    MovingHull hull;
    hull.corners = 2;
    hull.radius = radius;
    hull.x_t0[0] = hull.x_t0[1] = from;
    hull.x_t1[0] = hull.x_t1[1] = to;
    return find_hull_impact(hull, triangle, triangle);
  }
};

TEST(Impact, ARadiusThatIsNoNumberHitsNothing) {
  for (const double radius : {kNan, kInfinity}) {
    EXPECT_FALSE(Shot(1, radius).of_sphere());
    EXPECT_FALSE(Shot(1, radius).of_capsule());
  }
}

TEST(Impact, TheNormalIsAUnitVectorWhereTheSquareOfAMotionUnderflows) {
  const Vec3 zero = Vec3::Zero(), triangle[3] = {zero, zero, zero};
  const auto hit = find_triangle_impact({ToolShape::Kind::sphere, 1}, {Vec3(0x1.f1f1f007a861fp-526, 0, 0), zero},
                                        triangle, triangle);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
}

TEST(Impact, TheValidRangeEndsWhereItSays) {
  for (const double scale : {kSmallestExtent, 1.0, 0.25 * kLargestCoordinate})
    for (const std::optional<Contact>& hit : {Shot(scale).of_sphere(), Shot(scale).of_capsule()}) {
      ASSERT_TRUE(hit) << scale;
      EXPECT_NEAR(hit->toi, 0.45, 1e-12) << scale;
      EXPECT_NEAR(hit->normal.z(), 1, 1e-12) << scale;
    }
  for (const double scale : {1e-300, 1e-160, 1e160, 1e300}) {  // where squares underflow and overflow
    EXPECT_FALSE(Shot(scale).of_sphere()) << scale;
    EXPECT_FALSE(Shot(scale).of_capsule()) << scale;
  }
}

}  // namespace
}  // namespace kt
