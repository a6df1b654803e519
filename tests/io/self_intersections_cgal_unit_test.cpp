#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

Mesh two_triangles(const VectorX& x, const std::vector<Triangle>& triangles) { return {x, triangles, {}}; }

std::size_t pairs(const Mesh& mesh) {
  bool complete = false;
  const std::size_t n = find_self_intersections(mesh, 100, complete).size();
  EXPECT_TRUE(complete);
  return n;
}

TEST(SelfIntersections, PiercingIsFoundAndNeighbourhoodIsNot) {
  const VectorX apart{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1}};
  EXPECT_EQ(pairs(two_triangles(apart, {{0, 1, 2}, {3, 4, 5}})), 0u);
  VectorX pierced = apart;
  pierced.segment<3>(9) = Vec3(0.2, 0.2, -1);
  EXPECT_EQ(pairs(two_triangles(pierced, {{0, 1, 2}, {3, 4, 5}})), 1u);
  EXPECT_EQ(pairs(two_triangles(apart, {{0, 1, 2}, {0, 4, 5}})), 0u);    // one common node
  EXPECT_EQ(pairs(two_triangles(pierced, {{0, 1, 2}, {0, 3, 5}})), 1u);  // one common node and a crossing
}

TEST(SelfIntersections, AFoldedNeighbourOverlapsAndAFlatOneDoesNot) {
  const VectorX x{{0, 0, 0, 1, 0, 0, 0.3, 1, 0, 0.5, 0.5, 0, 0.5, -1, 0}};
  EXPECT_EQ(pairs(two_triangles(x, {{0, 1, 2}, {1, 0, 3}})), 1u);
  EXPECT_EQ(pairs(two_triangles(x, {{0, 1, 2}, {1, 0, 4}})), 0u);
}

TEST(SelfIntersections, TouchingAtEqualButSeparateNodesIsNoIntersection) {
  const VectorX x{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, -1, 0}};
  EXPECT_EQ(pairs(two_triangles(x, {{0, 1, 2}, {3, 4, 5}})), 0u);
}

TEST(SelfIntersections, TheSearchStopsAtTheLimitAndSaysSo) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/broken/self_intersecting.off");
  bool complete = true;
  EXPECT_EQ(find_self_intersections(mesh, 5, complete).size(), 5u);
  EXPECT_FALSE(complete);
  EXPECT_EQ(find_self_intersections(mesh, 500, complete).size(), 12u);
  EXPECT_TRUE(complete);
}

}  // namespace
}  // namespace kt
