// Pairs of a surface with itself against all pairs, their distances against dense sampling, and when they meet.
#include "collision/broad/surface_pairs.hpp"

#include <gtest/gtest.h>

#include <set>

#include "collision/held/pair_distance.hpp"
#include "collision/held/surface_motion.hpp"
#include "core/body/mesh.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

struct Box {
  Vec3 low, high;
};

Box box_of(std::span<const int> nodes, const VectorX& x_t0, const VectorX& x_t1) {
  Box out{node(x_t0, nodes[0]), node(x_t0, nodes[0])};
  for (int i : nodes)
    for (const VectorX* x : {&x_t0, &x_t1}) {
      out.low = out.low.cwiseMin(Vec3(node(*x, i)));
      out.high = out.high.cwiseMax(Vec3(node(*x, i)));
    }
  return out;
}

bool near(const Box& a, const Box& b, double margin) {
  return ((a.low - b.high).array() <= margin).all() && ((b.low - a.high).array() <= margin).all();
}

using Key = std::array<int, 5>;

std::set<Key> all_pairs(const std::vector<Triangle>& triangles, const VectorX& x_t0, const VectorX& x_t1,
                        double margin) {
  std::set<Key> out;
  std::set<std::array<int, 2>> edges;
  std::set<int> vertices;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      vertices.insert(t[k]);
      edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    }
  for (int v : vertices)
    for (const Triangle& t : triangles)
      if (t[0] != v && t[1] != v && t[2] != v && near(box_of(std::array{v}, x_t0, x_t1), box_of(t, x_t0, x_t1), margin))
        out.insert({0, v, t[0], t[1], t[2]});
  for (const auto& a : edges)
    for (const auto& b : edges)
      if (a < b && a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1] &&
          near(box_of(a, x_t0, x_t1), box_of(b, x_t0, x_t1), margin))
        out.insert({1, a[0], a[1], b[0], b[1]});
  return out;
}

TEST(SurfacePairs, AreThoseWhoseBoxesMeetAndNoneTwice) {
  const Mesh mesh = kuhn_block(3, 2, 2, 0.01);
  VectorX x_t0 = mesh.x + 2e-3 * random_vector(mesh.x.size(), 1), x_t1 = x_t0 + 5e-3 * random_vector(x_t0.size(), 2);
  for (const BackendInfo& backend : triangle_index_backends()) {
    if (!backend.available) continue;
    SurfacePairs pairs(mesh.triangles, mesh.x, backend.name);
    for (double margin : {0.0, 1e-3}) {
      std::set<Key> found;
      for (const SurfacePair& p : pairs.find(x_t0, x_t1, margin)) {
        const Key key{p.kind == SurfacePair::Kind::edge_edge, p.nodes[0], p.nodes[1], p.nodes[2], p.nodes[3]};
        EXPECT_TRUE(found.insert(key).second);
      }
      EXPECT_EQ(found, all_pairs(mesh.triangles, x_t0, x_t1, margin)) << backend.name;
    }
  }
}

TEST(PairDistance, IsTheLeastOverBothFeatures) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    VectorX x = random_vector(12, seed);
    if (seed % 4 == 1) node(x, 3) = node(x, 2);                                        // no edge, no area
    if (seed % 4 == 2) node(x, 3) = node(x, 2) + 0.7 * Vec3(node(x, 1) - node(x, 0));  // parallel edges
    for (const auto kind : {SurfacePair::Kind::vertex_face, SurfacePair::Kind::edge_edge}) {
      const PairDistance d = pair_distance({kind, {0, 1, 2, 3}}, x);
      double least = 1e9;
      const int n = 60;
      for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= n; ++k) {
          const double s = i / double(n), t = k / double(n);
          if (kind == SurfacePair::Kind::edge_edge)
            least =
                std::min(least, ((1 - s) * node(x, 0) + s * node(x, 1) - (1 - t) * node(x, 2) - t * node(x, 3)).norm());
          else if (s + t <= 1)
            least = std::min(least, (node(x, 0) - (1 - s - t) * node(x, 1) - s * node(x, 2) - t * node(x, 3)).norm());
        }
      EXPECT_LE(d.distance, least + 1e-12) << seed;
      EXPECT_GE(d.distance, least - 0.06) << seed;
      Vec3 apart = Vec3::Zero();
      double sum = 0;
      for (int i = 0; i < 4; ++i) {
        apart += d.weight[i] * node(x, i);
        sum += d.weight[i];
      }
      EXPECT_NEAR((apart - d.distance * d.normal).norm(), 0, 1e-12);
      EXPECT_NEAR(sum, 0, 1e-14);
      const auto distance = [&](const VectorX& y) {
        return VectorX(VectorX::Constant(1, pair_distance({kind, {0, 1, 2, 3}}, y).distance));
      };
      if (seed % 4 != 0) continue;  // elsewhere the closest points may jump
      const MatrixX gradient = central_differences(distance, x, 1e-7);
      for (int i = 0; i < 4; ++i)
        EXPECT_NEAR((gradient.middleCols<3>(3 * i).transpose() - d.weight[i] * d.normal).norm(), 0, 1e-5) << seed;
    }
  }
}

TEST(FirstMeeting, IsThatOfTheFirstPairAndNeverLate) {
  // A vertex falls on a triangle at 0.25 of the step, an edge on an edge at 0.5.
  VectorX x_t0(24), x_t1;
  x_t0 << 0.2, 0.2, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0,  //
      5, 0, 2, 6, 0, 2, 5.5, -1, 0, 5.5, 1, 0;
  x_t1 = x_t0;
  for (int i : {0, 4, 5}) x_t1[3 * i + 2] -= 4;
  const SurfacePair drop{SurfacePair::Kind::vertex_face, {0, 1, 2, 3}},
      cross{SurfacePair::Kind::edge_edge, {4, 5, 6, 7}};
  const auto meeting = [&](std::vector<SurfacePair> pairs) { return first_meeting(pairs, x_t0, x_t1); };
  EXPECT_NEAR(meeting({drop, cross}), 0.25, 1e-12);
  EXPECT_LE(meeting({drop, cross}), 0.25);
  EXPECT_NEAR(meeting({cross}), 0.5, 1e-12);
  EXPECT_TRUE(std::isinf(meeting({})));
  x_t1[2] = x_t0[2] - 0.5;
  EXPECT_TRUE(std::isinf(meeting({drop})));
  x_t1[2] = std::nan("");
  EXPECT_EQ(meeting({drop}), 0);
}

}  // namespace
}  // namespace kt
