// Which corners and edges of a mesh can be the first to touch.
#include "collision/shape/tool_features.hpp"

#include <gtest/gtest.h>

#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

TEST(ToolFeatures, OfABoxInManyPiecesAreThoseOfABox) {
  for (const int pieces : {1, 2, 4}) {  // whose quads have corners of their own
    ToolShape box = box_tool({3e-3, 2e-3, 1e-3}, pieces, 5e-4);
    const Quaternion turn(Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()));  // coordinates are rounded then
    for (const bool turned : {false, true}) {
      if (turned)
        for (Vec3& x : box.corners) x = (turn * x + Vec3(0.1, 0.2, 0.3)).eval();
      const ToolFeatures found = find_tool_features(box);
      EXPECT_EQ(found.corners.size(), turned ? found.corners.size() : 8u);
      if (turned) continue;  // corners of several quads need not be in one place to the last bit
      EXPECT_EQ(found.edges.size(), 12u);
      double length = 0;
      for (const auto& [a, b] : found.edges) length += (box.corners[a] - box.corners[b]).norm();
      EXPECT_NEAR(length, 4 * (6e-3 + 4e-3 + 2e-3), 1e-15);
    }
  }
}

TEST(ToolFeatures, OfATurnedMeshWithCommonCornersAreFound) {
  ToolShape plate{ToolShape::Kind::mesh, 1e-3, {}, {}};  // 3 x 3 corners in a plane, of two sides, and a tip above
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) plate.corners.push_back(Vec3(i, k, 0));
  plate.corners.push_back(Vec3(1, 1, 2));
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k) {
      const int a = 3 * i + k;
      plate.triangles.push_back({a, a + 1, a + 4});
      plate.triangles.push_back({a, a + 4, a + 3});
    }
  for (const std::array<int, 2>& rim : {std::array{0, 3}, {3, 6}, {6, 7}, {7, 8}, {8, 5}, {5, 2}, {2, 1}, {1, 0}})
    plate.triangles.push_back({rim[0], rim[1], 9});
  const Quaternion turn(Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()));
  for (const bool turned : {false, true}) {
    if (turned)
      for (Vec3& x : plate.corners) x = (1e-3 * (turn * x)).eval();
    const ToolFeatures found = find_tool_features(plate);
    EXPECT_EQ(found.corners, (std::vector<int>{0, 2, 6, 8, 9}));
    EXPECT_EQ(found.edges,
              (std::vector<std::array<int, 2>>{{0, 2}, {0, 6}, {0, 9}, {2, 8}, {2, 9}, {6, 8}, {6, 9}, {8, 9}}));
    EXPECT_EQ(found.goes_on[0] & 7, 6);  // its first edge is at the rim
  }
}

TEST(ToolFeatures, BentByLittleStay) {
  ToolShape bent{ToolShape::Kind::mesh, 1e-3, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, -1e-7}}, {{0, 1, 2}, {1, 3, 2}}};
  EXPECT_EQ(find_tool_features(bent).edges.size(), 5u);
  bent.corners[3].z() = 0;
  EXPECT_EQ(find_tool_features(bent).edges.size(), 4u);
  bent.triangles[1] = {1, 2, 3};  // listed the other way round: still one plane
  EXPECT_EQ(find_tool_features(bent).edges.size(), 4u);
  bent.corners[3] = Vec3(0.2, 0.2, 0);  // folded over: in one plane, not on both sides
  EXPECT_EQ(find_tool_features(bent).edges.size(), 5u);
}

TEST(ToolFeatures, OfRoundToolsAreTheirs) {
  EXPECT_EQ(find_tool_features({ToolShape::Kind::sphere, 1e-3}).corners, std::vector<int>{0});
  const ToolFeatures capsule = find_tool_features(make_capsule(1e-3, 5e-3));
  EXPECT_EQ(capsule.corners, (std::vector<int>{0, 1}));
  EXPECT_EQ(capsule.edges, (std::vector<std::array<int, 2>>{{0, 1}}));
}

}  // namespace
}  // namespace kt
