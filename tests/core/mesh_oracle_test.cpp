// Geometry of meshes against counting, closed forms and brute force.
#include <gtest/gtest.h>

#include <map>

#include "core/base/error.hpp"
#include "core/body/surface.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-14;  // sums of some hundred terms of order one, relative

TEST(KuhnBlock, HasTheVolumeSurfaceAndEulerNumberOfABox) {
  const Mesh block = kuhn_block(3, 2, 4, 0.5);
  EXPECT_EQ(block.num_nodes(), 4 * 3 * 5);
  EXPECT_EQ(block.tetrahedra.size(), 6u * 3 * 2 * 4);
  EXPECT_EQ(block.triangles.size(), 4u * (3 * 2 + 2 * 4 + 3 * 4));
  double volume = 0, area = 0;
  for (const Tetrahedron& t : block.tetrahedra) {
    EXPECT_GT(tetrahedron_volume(block.x, t), 0);
    volume += tetrahedron_volume(block.x, t);
  }
  for (const Triangle& t : block.triangles) {
    const Vec3 a = node(block.x, t[0]);
    area += 0.5 * (node(block.x, t[1]) - a).cross(node(block.x, t[2]) - a).norm();
  }
  EXPECT_NEAR(volume, 3, 3 * kRoundoff);
  EXPECT_NEAR(enclosed_volume(block), 3, 3 * kRoundoff);  // signed: the surface looks outward
  EXPECT_NEAR(area, 13, 13 * kRoundoff);
}

TEST(BoundaryTriangles, AreTheFacesWithATetrahedronOnOneSideOnlyAndLookAwayFromIt) {
  Mesh block = kuhn_block(2, 2, 2, 1);
  std::erase_if(block.tetrahedra, [i = 0](const Tetrahedron&) mutable { return i++ % 5 == 0; });  // ragged
  const std::vector<Triangle> found = boundary_triangles(block.tetrahedra);
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  std::map<Triangle, Triangle> by_key;
  for (const Triangle& t : found) EXPECT_TRUE(by_key.emplace(sorted(t), t).second);
  std::size_t expected = 0;
  for (const Tetrahedron& t : block.tetrahedra)
    for (int left_out = 0; left_out < 4; ++left_out) {
      Triangle face{};
      for (int c = 0, k = 0; c < 4; ++c)
        if (c != left_out) face[k++] = t[c];
      int owners = 0;
      for (const Tetrahedron& other : block.tetrahedra)
        owners += std::all_of(face.begin(), face.end(),
                              [&](int i) { return std::find(other.begin(), other.end(), i) != other.end(); });
      ASSERT_EQ(by_key.count(sorted(face)), owners == 1 ? 1u : 0u);
      if (owners != 1) continue;
      ++expected;
      const Triangle& s = by_key.at(sorted(face));
      const Vec3 a = node(block.x, s[0]);
      const Vec3 normal = (node(block.x, s[1]) - a).cross(node(block.x, s[2]) - a);
      EXPECT_LT(normal.dot(node(block.x, t[left_out]) - a), 0);
    }
  EXPECT_EQ(found.size(), expected);
}

TEST(EnclosedVolume, IsTheDeterminantUnderAnyAffineMap) {
  Mesh block = kuhn_block(2, 1, 1, 1);
  const Mat3 map = random_vector(9, 1).reshaped(3, 3);
  for (int i = 0; i < block.num_nodes(); ++i) node(block.x, i) = map * Vec3(node(block.x, i)) + Vec3(100, -7, 3);
  EXPECT_NEAR(enclosed_volume(block), 2 * map.determinant(), 1e-12);  // 1e-12: positions of order 100
}

TEST(NodeNormals, PointOutOfABoxAndVanishInside) {
  const Mesh block = kuhn_block(2, 2, 2, 1);
  const VectorX n = node_normals(block.x, block.triangles);
  EXPECT_EQ(node(n, 13), Vec3::Zero());  // the centre
  EXPECT_LE((node(n, 4) + Vec3::UnitZ()).norm(), kRoundoff);
  EXPECT_LE((node(n, 14) - Vec3::UnitX()).norm(), kRoundoff);
  for (int i = 0; i < block.num_nodes(); ++i)
    EXPECT_TRUE(i == 13 || node(n, i).dot(node(block.x, i) - Vec3::Ones()) > 0.5) << i;
}

TEST(Bounds, AreThoseOfTheNodes) {
  EXPECT_EQ(bounds(Mesh{}).size(), Vec3::Zero());
  const Bounds b = bounds(kuhn_block(2, 1, 3, 1));
  EXPECT_EQ(b.min, Vec3::Zero());
  EXPECT_EQ(b.max, Vec3(2, 1, 3));
  EXPECT_EQ(b.centre(), Vec3(1, 0.5, 1.5));
}

/// Triangles with edge (a, b) in either direction.
std::vector<int> around_edge(const std::vector<Triangle>& triangles, int a, int b) {
  std::vector<int> out;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    if (std::count(triangles[t].begin(), triangles[t].end(), a) &&
        std::count(triangles[t].begin(), triangles[t].end(), b))
      out.push_back(t);
  return out;
}

void expect_topology_by_brute_force(const std::vector<Triangle>& triangles, int num_nodes) {
  const SurfaceTopology topology = make_topology(triangles, num_nodes);
  for (int i = 0; i < num_nodes; ++i) {
    std::vector<int> fan;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
      if (std::count(triangles[t].begin(), triangles[t].end(), i)) fan.push_back(t);
    const auto found = topology.triangles_of(i);
    EXPECT_EQ(std::vector<int>(found.begin(), found.end()), fan) << "node " << i;
  }
  ASSERT_EQ(topology.across.size(), triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int c = 0; c < 3; ++c) {
      const std::vector<int> around = around_edge(triangles, triangles[t][c], triangles[t][(c + 1) % 3]);
      const int expected = around.size() == 1 ? -1 : around.size() > 2 ? -2 : around[0] == t ? around[1] : around[0];
      EXPECT_EQ(topology.across[t][c], expected) << "triangle " << t << " edge " << c;
    }
}

TEST(SurfaceTopology, IsThatOfBruteForceOnClosedOpenAndNonManifoldSurfaces) {
  const Mesh block = kuhn_block(2, 1, 2, 1), flat = sheet(3, 2, 1);
  expect_topology_by_brute_force(block.triangles, block.num_nodes());
  expect_topology_by_brute_force(flat.triangles, flat.num_nodes());
  expect_topology_by_brute_force({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 1, 2}}, 6);  // a book, a page twice, a lone node
  expect_topology_by_brute_force({}, 2);
}

}  // namespace
}  // namespace kt
