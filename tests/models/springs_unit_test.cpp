// From meshes to springs and masses: hand values.
#include "models/msd/springs.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-14;

TEST(Springs, AreTheEdgesOnceEachInAscendingOrder) {
  const std::vector<Spring> s = make_springs(one_tetrahedron(2));
  ASSERT_EQ(s.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_LT(s[i].a, s[i].b);
    EXPECT_TRUE(i == 0 || std::pair(s[i - 1].a, s[i - 1].b) < std::pair(s[i].a, s[i].b));
    EXPECT_NEAR(s[i].rest_length, s[i].a == 0 ? 2 : std::sqrt(8.0), kRoundoff);
  }
  // Nodes minus edges plus faces minus cells is one for a ball: faces = (4 cells + surface) / 2.
  const Mesh block = kuhn_block(2, 3, 1, 1);
  const std::size_t cells = block.tetrahedra.size(), faces = (4 * cells + block.triangles.size()) / 2;
  EXPECT_EQ(make_springs(block).size(), block.num_nodes() + faces - cells - 1);
}

TEST(Springs, OfASurfaceAreItsTriangleEdges) { EXPECT_EQ(make_springs(sheet(2, 1, 1)).size(), 9u); }

TEST(Springs, NameTheNodesOfAnEdgeWithoutLength) {
  Mesh mesh = one_tetrahedron(1);
  node(mesh.x, 2) = node(mesh.x, 1);
  try {
    make_springs(mesh);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "msd: nodes 1 and 2 of one edge lie on the same point");
  }
}

TEST(LumpedMasses, AreQuartersOfTetrahedraOrThirdsOfTriangles) {
  const VectorX solid = lumped_masses(one_tetrahedron(1), 24, 99);
  for (double m : solid) EXPECT_NEAR(m, 1, kRoundoff);
  const VectorX membrane = lumped_masses(sheet(3, 2, 0.5), 1000, 0.01);
  EXPECT_NEAR(membrane.sum(), 1000 * 0.01 * 1.5, 15 * kRoundoff);
  EXPECT_NEAR(membrane[0], 1000 * 0.01 * 0.125 * 2 / 3, kRoundoff);  // two of the triangles of 1/8 m^2
}

TEST(InnerLayers, OfASheetAreASlabWithTheSurfaceOnTop) {
  const Mesh top = sheet(3, 2, 0.01);
  const Mesh slab = add_inner_layers(top, 4, 0.02);
  EXPECT_EQ(slab.num_nodes(), 5 * top.num_nodes());
  EXPECT_EQ(slab.tetrahedra.size(), 3u * 4 * top.triangles.size());
  EXPECT_EQ(slab.triangles, top.triangles);
  EXPECT_EQ(slab.x.head(top.x.size()), top.x);
  EXPECT_NEAR(node(slab.x, 4 * top.num_nodes()).z(), -0.02, kRoundoff);
  double volume = 0;
  for (const Tetrahedron& t : slab.tetrahedra) {
    EXPECT_GT(tetrahedron_volume(slab.x, t), 0);
    volume += tetrahedron_volume(slab.x, t);
  }
  EXPECT_NEAR(volume, 0.03 * 0.02 * 0.02, kRoundoff);
  // Prisms that disagreed on a shared diagonal would leave inner faces without a partner.
  EXPECT_EQ(boundary_triangles(slab.tetrahedra).size(), 2 * top.triangles.size() + 2u * 4 * 10);
}

TEST(InnerLayers, SayWhenTheyWouldFoldOrMakeNoSense) {
  const Mesh box = kuhn_block(2, 2, 2, 0.01);
  const Mesh surface{box.x, box.triangles, {}};
  EXPECT_NO_THROW(add_inner_layers(sheet(1, 1, 1), 1, 0.1));
  EXPECT_THROW(add_inner_layers(surface, 1, 0.05), InputError);
  EXPECT_THROW(add_inner_layers(surface, 0, 0.001), InputError);
  EXPECT_THROW(add_inner_layers(surface, 1, 0), InputError);
}

}  // namespace
}  // namespace kt
