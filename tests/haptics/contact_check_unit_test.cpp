#include "haptics/tick/contact_check.hpp"

#include <gtest/gtest.h>

#include "core/body/surface.hpp"

namespace kt {
namespace {

/// A square of two triangles that face up, and a flap beside them, whose faces look down.
struct FoldedSheet {
  SurfacePatch patch;
  VectorX x{3 * 8};

  explicit FoldedSheet(double flap_height) {
    x << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0,
        // the flap: its edge along y at x = 0.5 is what is nearest to the ball
        0.5, -1, flap_height, 0.5, 1, flap_height, 3, 1, flap_height - 1, 3, -1, flap_height - 1;
    patch.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    for (int i = 0; i < 8; ++i) patch.global_node.push_back(i);
    patch.topology = make_topology(patch.triangles, 8);
  }
  double depth(const Vec3& place, double radius) const {
    ToolShape ball;
    ball.kind = ToolShape::Kind::sphere;
    ball.radius = radius;
    return penetration_depth(patch, x, ball, place);
  }
};

TEST(PenetrationDepth, OfABallAboveInAndBelowASheet) {
  const FoldedSheet sheet(-5);
  EXPECT_EQ(sheet.depth({0, 0, 0.6}, 0.5), 0);
  EXPECT_NEAR(sheet.depth({0, 0, 0.4}, 0.5), 0.1, 1e-15);
  EXPECT_NEAR(sheet.depth({0, 0, -0.4}, 0.5), 0.9, 1e-15);
}

/// It rests on the square, and touches the flap's edge from the flap's back: its centre is not inside for that.
TEST(PenetrationDepth, OfABallThatTouchesAFoldFromBehind) {
  const double r = 0.5, height = r - std::sqrt(r * r - 0.25 * 0.25);
  for (const double nearer : {-1e-6, 0.0, 1e-6}) {
    const FoldedSheet sheet(height + nearer);
    EXPECT_LE(sheet.depth({0.25, 0, r}, r), 2 * std::abs(nearer) + 1e-15) << nearer;
  }
  EXPECT_GE(FoldedSheet(height + 0.01).depth({0.25, 0, r}, r), r);  // nothing else is as near: inside
}

TEST(PenetrationDepth, ATriangleWithoutAreaHidesNothing) {
  FoldedSheet sheet(-5);
  sheet.x.conservativeResize(3 * 11);
  sheet.x.tail<9>() << -1, 0.1, 0, 1, 0.1, 0, 0, 0.1, 0;
  sheet.patch.triangles.push_back({8, 9, 10});
  for (int i = 8; i < 11; ++i) sheet.patch.global_node.push_back(i);
  sheet.patch.topology = make_topology(sheet.patch.triangles, 11);
  EXPECT_NEAR(sheet.depth({0, 0.1, -0.4}, 0.5), 0.9, 1e-15);
  EXPECT_NEAR(sheet.depth({0, 0.1, 0.4}, 0.5), 0.1, 1e-15);
}

}  // namespace
}  // namespace kt
