// Every broad phase of the table: a superset of what can be touched, and with the narrow phase the same contacts bit
// for bit.
#include "collision/broad/triangle_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "collision/held/first_contact.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/triangle_indices.hpp"

namespace kt {
namespace {

class EveryTriangleIndex : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<TriangleIndex> index = make_triangle_index(GetParam());
};

TEST_P(EveryTriangleIndex, FindsEveryBoxOnThePathAfterAnyMotion) {
  Sample s{std::mt19937_64(21)};
  for (int i = 0; i < 300; ++i) {
    const Motion m = random_motion(s);
    index->build(m.triangles, m.x_rest);
    index->refit(m.x_t0, m.x_t1);
    std::vector<int> out(m.triangles.size(), -1);
    for (int k = 0; k < 10; ++k) {
      const ToolSweep sweep = random_sweep(s, m);
      const double margin = k % 2 ? 0 : 0.1 * (sweep.x_t1 - sweep.x_t0).norm();
      const int count = index->candidates(sweep, margin, out);
      ASSERT_LE(count, static_cast<int>(out.size()));
      const std::span found(out.data(), static_cast<std::size_t>(count));
      EXPECT_TRUE(std::ranges::is_sorted(found, std::less_equal<>{}) || count < 2);
      EXPECT_EQ(std::ranges::adjacent_find(found, std::greater_equal<>{}), found.end());
      const std::vector<int> met = boxes_met(m, sweep, margin);
      EXPECT_TRUE(std::ranges::includes(found, met)) << i << " " << k;
    }
  }
}

TEST_P(EveryTriangleIndex, GivesTheSameFirstContactBitForBit) {
  Sample s{std::mt19937_64(22)};
  const auto reference = make_triangle_index("brute_force");
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Motion m = random_motion(s);
    index->build(m.triangles, m.x_rest);
    reference->build(m.triangles, m.x_rest);
    index->refit(m.x_t0, m.x_t1);
    reference->refit(m.x_t0, m.x_t1);
    const MovingTriangles surface{m.triangles, m.x_t0, m.x_t1};
    std::vector<int> scratch(m.triangles.size());
    std::vector<unsigned char> ignored(m.triangles.size());
    for (auto& flag : ignored) flag = s.uniform(0, 1) < 0.1;
    for (int k = 0; k < 10; ++k) {
      const ToolSweep sweep = random_sweep(s, m);
      const double radius = k % 2 ? 0 : 0.05 * (sweep.x_t1 - sweep.x_t0).norm();
      const ToolShape tool{k % 2 ? ToolShape::Kind::point : ToolShape::Kind::sphere, radius};
      const auto expected = find_first_contact(*reference, surface, tool, sweep, ignored, scratch);
      EXPECT_EQ(find_first_contact(*index, surface, tool, sweep, ignored, scratch), expected);
      // No candidate list at all must give the same.
      std::optional<Contact> first;
      for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        const Triangle& v = m.triangles[t];
        const Vec3 t0[3] = {node(m.x_t0, v[0]), node(m.x_t0, v[1]), node(m.x_t0, v[2])};
        const Vec3 t1[3] = {node(m.x_t1, v[0]), node(m.x_t1, v[1]), node(m.x_t1, v[2])};
        auto hit = ignored[t] ? std::nullopt : find_triangle_impact(tool, sweep, t0, t1);
        if (!hit || (first && first->toi <= hit->toi)) continue;
        first = hit;
        first->triangle = static_cast<int>(t);
      }
      EXPECT_EQ(expected, first) << i << " " << k;
      hits += expected.has_value();
    }
  }
  EXPECT_GT(hits, 300);
}

TEST_P(EveryTriangleIndex, OrderOfTheTrianglesDoesNotChangeTheImpact) {
  Sample s{std::mt19937_64(23)};
  for (int i = 0; i < 100; ++i) {
    const Motion m = random_motion(s);
    std::vector<int> order(m.triangles.size());
    for (std::size_t t = 0; t < order.size(); ++t) order[t] = static_cast<int>(t);
    std::shuffle(order.begin(), order.end(), s.random);
    std::vector<Triangle> shuffled;
    for (const int t : order) shuffled.push_back(m.triangles[static_cast<std::size_t>(t)]);
    const ToolSweep sweep = random_sweep(s, m);
    std::vector<int> scratch(m.triangles.size());
    const auto first = [&](const std::vector<Triangle>& triangles) {
      index->build(triangles, m.x_rest);
      index->refit(m.x_t0, m.x_t1);
      return find_first_contact(*index, {triangles, m.x_t0, m.x_t1}, {}, sweep, {}, scratch);
    };
    const auto a = first(m.triangles), b = first(shuffled);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      EXPECT_EQ(a->toi, b->toi);  // of several triangles hit at once the lowest number may differ
    }
  }
}

TEST_P(EveryTriangleIndex, NamesTheSameTrianglesAsBruteForce) {
  Sample s{std::mt19937_64(25)};
  const auto reference = make_triangle_index("brute_force");
  std::size_t named = 0;
  for (int i = 0; i < 300; ++i) {
    const Motion m = random_motion(s);
    for (const auto& any : {index.get(), reference.get()}) {
      any->build(m.triangles, m.x_rest);
      any->refit(m.x_t0, m.x_t1);
    }
    for (int k = 0; k < 10; ++k) {
      const ToolSweep sweep = random_sweep(s, m);
      const double margin = k % 2 ? 0 : 0.1 * (sweep.x_t1 - sweep.x_t0).norm();
      const std::vector<int> expected = candidates_of(*reference, sweep, margin, m.triangles.size());
      EXPECT_EQ(candidates_of(*index, sweep, margin, m.triangles.size()), expected) << i << " " << k;
      named += expected.size();
    }
  }
  EXPECT_GT(named, 10000u);
}

/// Paths that touch a box in one corner, or miss it by the last place, where a float cannot tell the difference.
TEST_P(EveryTriangleIndex, SeesALastPlaceFarFromTheOrigin) {
  Sample s{std::mt19937_64(26)};
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double offset : {0.0, 1e6, 1e12}) {
    Motion m;
    m.x_rest.resize(3 * 60);
    for (int i = 0; i < 60; ++i) node(m.x_rest, i) = 0.01 * s.cube() + (i % 7 ? offset : 0) * Vec3(1, -1, 1);
    for (int v = 0; v + 2 < 60; ++v) m.triangles.push_back({v, v + 1, v + 2});
    m.x_t0 = m.x_rest;
    m.x_t1 = m.x_rest;
    for (int i = 0; i < 60; ++i) node(m.x_t1, i) += 1e-3 * s.cube();
    index->build(m.triangles, m.x_rest);
    index->refit(m.x_t0, m.x_t1);
    for (const Triangle& t : m.triangles)
      for (const double side : {-1.0, 1.0}) {
        Vec3 corner = side * node(m.x_t0, t[0]);
        for (const int v : t) corner = corner.cwiseMax(side * node(m.x_t0, v)).cwiseMax(side * node(m.x_t1, v));
        corner *= side;
        const ToolSweep touching{corner, corner};
        EXPECT_EQ(candidates_of(*index, touching, 0, m.triangles.size()), boxes_met(m, touching, 0)) << offset;
        for (int axis = 0; axis < 3; ++axis) {
          ToolSweep beside = touching;
          for (Vec3* end : {&beside.x_t0, &beside.x_t1}) (*end)[axis] = std::nextafter(corner[axis], side * infinity);
          EXPECT_EQ(candidates_of(*index, beside, 0, m.triangles.size()), boxes_met(m, beside, 0)) << offset;
        }
      }
  }
}

/// A point-sized box has no room for what single precision loses.
TEST_P(EveryTriangleIndex, SeesACollapsedTriangleAtTheCornerOfAPath) {
  Sample s{std::mt19937_64(27)};
  for (const double offset : {0.0, 1.0, 1e6}) {
    Motion m;
    m.x_rest.resize(3 * 200);
    for (int v = 0; v < 200; ++v) {
      node(m.x_rest, v) = 0.01 * s.cube() + (v ? offset : 0) * Vec3(1, -1, 1);
      m.triangles.push_back({v, v, v});
    }
    m.x_t0 = m.x_t1 = m.x_rest;
    index->build(m.triangles, m.x_rest);
    for (int v = 0; v < 200; ++v) {
      const Vec3 p = node(m.x_rest, v);
      const ToolSweep sweep{p, p + 0.003 * s.cube()};
      const std::vector<int> met = boxes_met(m, sweep, 0);
      EXPECT_TRUE(std::ranges::binary_search(met, v));
      EXPECT_EQ(candidates_of(*index, sweep, 0, m.triangles.size()), met) << offset;
    }
  }
}

/// At the build, in the tick, or from the build on until it heals.
TEST_P(EveryTriangleIndex, AVertexThatIsNoNumberHidesNothing) {
  const Mesh mesh = sheet(4, 4, 0.01);
  const ToolSweep sweep{{0.03, 0.035, 0.001}, {0.03, 0.035, -0.001}}, elsewhere{{9, 9, 9}, {9, 9, 8}};
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300})
    for (const int vertex : {0, 12})
      for (const int axis : {0, 2}) {
        VectorX x = mesh.x;
        x[3 * vertex + axis] = bad;
        for (const auto& [x_built, x_t1] : {std::pair(mesh.x, x), {x, x}, {x, mesh.x}}) {
          const Motion m{mesh.triangles, x_built, x_built, x_t1};
          index->build(m.triangles, x_built);
          EXPECT_EQ(candidates_of(*index, elsewhere, 0, m.triangles.size()),
                    boxes_met({m.triangles, x_built, x_built, x_built}, elsewhere, 0));
          index->refit(m.x_t0, m.x_t1);
          for (const ToolSweep& path : {sweep, elsewhere})
            EXPECT_EQ(candidates_of(*index, path, 0, m.triangles.size()), boxes_met(m, path, 0)) << bad << vertex;
          std::vector<int> scratch(m.triangles.size());
          if (vertex == 0) {
            EXPECT_TRUE(find_first_contact(*index, {m.triangles, m.x_t0, m.x_t1}, {}, sweep, {}, scratch));
          }
          index->refit(mesh.x, mesh.x);
          EXPECT_EQ(candidates_of(*index, sweep, 0, m.triangles.size()),
                    boxes_met({mesh.triangles, mesh.x, mesh.x, mesh.x}, sweep, 0));
        }
      }
}

TEST_P(EveryTriangleIndex, AToolThatIsNoNumberOrVeryFastMeetsEverythingOnItsPath) {
  const Mesh mesh = sheet(4, 4, 0.01);
  index->build(mesh.triangles, mesh.x);
  std::vector<int> all(mesh.triangles.size());
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = static_cast<int>(t);
  const double infinity = std::numeric_limits<double>::infinity();
  const Vec3 bad(0.01, std::numeric_limits<double>::quiet_NaN(), 0), good(0.01, 0.01, 0);
  EXPECT_EQ(candidates_of(*index, {good, bad}, 0, all.size()), all);
  EXPECT_EQ(candidates_of(*index, {bad, good}, 0, all.size()), all);
  EXPECT_EQ(candidates_of(*index, {good, good}, infinity, all.size()), all);
  for (const double far : {1e10, 1e20, 1e39, 1e300}) {
    EXPECT_EQ(candidates_of(*index, {Vec3::Constant(-far), Vec3::Constant(far)}, 0, all.size()), all) << far;
    EXPECT_TRUE(candidates_of(*index, {Vec3::Constant(far), Vec3::Constant(2 * far)}, 0, all.size()).empty()) << far;
  }
}

TEST_P(EveryTriangleIndex, NeedsNoMemoryInTheTick) {
  Sample s{std::mt19937_64(24)};
  const Motion m = random_motion(s);
  index->build(m.triangles, m.x_rest);
  std::vector<int> scratch(m.triangles.size());
  const MovingTriangles surface{m.triangles, m.x_t0, m.x_t1};
  const ToolSweep sweep = random_sweep(s, m);
  const std::vector<int> moved = {3, 1, 4};
  VectorX x = m.x_t1, more_t0 = m.x_t0, more_t1 = m.x_t1;  // with a vertex that no triangle has, as of an apron
  more_t0.conservativeResize(more_t0.size() + 3);
  more_t1.conservativeResize(more_t1.size() + 3);
  more_t0.tail<3>().setZero();
  more_t1.tail<3>().setZero();
  int hits = 0;
  EXPECT_EQ(allocations_during([&] {
              index->refit(more_t0, more_t1);
              for (int i = 0; i < 10; ++i) {
                index->refit(m.x_t0, m.x_t1);
                hits += find_first_contact(*index, surface, {}, sweep, {}, scratch).has_value();
                for (const int v : moved) x[3 * v] += 0.1;
                index->refit_moved(moved, m.x_t0, x);
                hits += index->candidates(sweep, 10, scratch);
              }
            }),
            0);
  EXPECT_GT(hits, 0);
}

TEST_P(EveryTriangleIndex, TakesOneTriangleAndTheSameOneManyTimes) {
  const VectorX x{{0, 0, 0, 1, 0, 0, 0, 1, 0}};
  for (const int times : {1, 2, 3, 4, 5, 1000}) {
    index->build(std::vector<Triangle>(static_cast<std::size_t>(times), {0, 1, 2}), x);
    EXPECT_EQ(candidates_of(*index, {{0.5, 0.5, 1}, {0.5, 0.5, -1}}, 0, 1000).size(), static_cast<std::size_t>(times));
    EXPECT_TRUE(candidates_of(*index, {{0.5, 0.5, 1}, {0.5, 0.5, 2}}, 0, 1000).empty());
  }
}

TEST_P(EveryTriangleIndex, NoTrianglesAreNoCandidates) {
  const VectorX none;
  index->build({}, none);
  index->refit(none, none);
  index->refit_moved({}, none, none);
  EXPECT_EQ(index->candidates({{0, 0, 0}, {1, 1, 1}}, 1, {}), 0);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryTriangleIndex, testing::ValuesIn(available_triangle_indices()),
                         [](const auto& backend) { return backend.param; });

}  // namespace
}  // namespace kt
