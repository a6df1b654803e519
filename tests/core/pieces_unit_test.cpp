#include "core/body/pieces.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

/// A second block behind the first, its nodes its own.
Mesh with_another(Mesh body, const Mesh& other, const Vec3& moved) {
  const int n = body.num_nodes();
  body.x.conservativeResize(body.x.size() + other.x.size());
  for (int i = 0; i < other.num_nodes(); ++i) node(body.x, n + i) = node(other.x, i) + moved;
  for (Tetrahedron t : other.tetrahedra) {
    for (int& i : t) i += n;
    body.tetrahedra.push_back(t);
  }
  body.triangles = boundary_triangles(body.tetrahedra);
  return body;
}

TEST(Pieces, ShareNoNode) {
  const Mesh one = kuhn_block(1, 1, 1, 1);
  int count = 0;
  EXPECT_EQ(pieces_of(one, count), std::vector<int>(8, 0));
  EXPECT_EQ(count, 1);
  const std::vector<int> piece = pieces_of(with_another(one, one, {0, 0, 1}), count);
  EXPECT_EQ(count, 2);
  EXPECT_EQ(piece[7], 0);
  EXPECT_EQ(piece[8], 1);
  Mesh unused = one;
  unused.x.conservativeResize(27);
  node(unused.x, 8) = Vec3(5, 5, 5);
  EXPECT_EQ(pieces_of(unused, count)[8], -1);
}

TEST(Pieces, ThreeNodesOnALineDoNotHoldStill) {
  const Mesh block = kuhn_block(2, 1, 1, 1);
  EXPECT_FALSE(holds_still(block, {}, 1));
  EXPECT_FALSE(holds_still(block, {0, 3}, 1));
  EXPECT_FALSE(holds_still(block, {0, 1, 2}, 2));
  EXPECT_TRUE(holds_still(block, {0, 1, 3}, 2));
}

/// The face between two blocks, off by less and by more than the tolerance.
TEST(CoincidentNodes, AreFoundWithinTheTolerance) {
  const Mesh one = kuhn_block(3, 3, 3, 1);
  for (const double off : {0.0, 0.9e-3, 1.1e-3}) {
    const Mesh two = with_another(one, one, {0, 0, 3 + off});
    const auto found = coincident_nodes(two, 1e-3);
    EXPECT_EQ(found.size(), off < 1e-3 ? 16u : 0u) << off;
    for (const std::vector<int>& group : found) {
      ASSERT_EQ(group.size(), 2u);
      EXPECT_LE((node(two.x, group[0]) - node(two.x, group[1])).norm(), 1e-3);
    }
  }
  EXPECT_TRUE(coincident_nodes(one, 1e-3).empty());
}

}  // namespace
}  // namespace kt
