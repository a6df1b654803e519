// Every broad phase of the table: a superset of what can be touched, and with the narrow phase the same contacts bit
// for bit.
#include "collision/triangle_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "collision/first_contact.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

struct Motion {
  std::vector<Triangle> triangles;
  VectorX x_rest, x_t0, x_t1;
};

/// A soup or a sheet, far from the origin now and then, that has moved since the build: a little, or far.
Motion random_motion(Sample& s) {
  Motion m;
  const double size = std::pow(10, s.uniform(-3, 1)), moved = size * std::pow(10, s.uniform(-4, 1));
  const Vec3 centre = s.uniform(0, 1) < 0.5 ? Vec3(Vec3::Zero()) : Vec3(100 * size * s.cube());
  if (s.uniform(0, 1) < 0.5) {
    const Mesh mesh = sheet(6, 5, size / 6);
    m.triangles = mesh.triangles;
    m.x_rest = mesh.x;
  } else {
    m.x_rest.resize(3 * 40);
    for (int i = 0; i < 40; ++i) node(m.x_rest, i) = size * s.cube();
    const auto any = [&] { return static_cast<int>(s.random() % 40); };
    for (int t = 0; t < 50; ++t) m.triangles.push_back({any(), any(), any()});
  }
  for (int i = 0; i < m.x_rest.size() / 3; ++i) node(m.x_rest, i) += centre;
  m.x_t0 = m.x_rest;
  m.x_t1 = m.x_rest;
  for (int i = 0; i < m.x_rest.size() / 3; ++i) {
    node(m.x_t0, i) += moved * s.cube();
    node(m.x_t1, i) = Vec3(node(m.x_t0, i)) + 0.3 * moved * s.cube();
  }
  return m;
}

ToolSweep random_sweep(Sample& s, const Motion& m) {
  const Vec3 near = node(m.x_t0, static_cast<int>(s.random() % static_cast<std::size_t>(m.x_t0.size() / 3)));
  const double size = (m.x_t0.maxCoeff() - m.x_t0.minCoeff()) * 0.3;
  return {near + size * s.cube(), near + size * s.cube()};
}

/// By definition: the swept boxes that the box of the path, grown by the margin, meets.
std::vector<int> boxes_met(const Motion& m, const ToolSweep& sweep, double margin) {
  std::vector<int> out;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const int v : m.triangles[t])
        for (const double x : {m.x_t0[3 * v + axis], m.x_t1[3 * v + axis]}) {
          low = std::min(low, x);
          high = std::max(high, x);
        }
      apart = apart || low > std::max(sweep.x_t0[axis], sweep.x_t1[axis]) + margin ||
              high < std::min(sweep.x_t0[axis], sweep.x_t1[axis]) - margin;
    }
    if (!apart) out.push_back(static_cast<int>(t));
  }
  return out;
}

std::vector<std::string> available_backends() {
  std::vector<std::string> out;
  for (const BackendInfo& b : triangle_index_backends())
    if (b.available) out.push_back(b.name);
  return out;
}

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

TEST_P(EveryTriangleIndex, AVertexThatIsNoNumberHidesNothing) {
  Mesh mesh = sheet(4, 4, 0.01);
  index->build(mesh.triangles, mesh.x);
  VectorX x = mesh.x;
  node(x, 0).setConstant(std::numeric_limits<double>::quiet_NaN());
  index->refit(x, x);
  std::vector<int> out(mesh.triangles.size());
  const ToolSweep sweep{{0.03, 0.035, 0.001}, {0.03, 0.035, -0.001}};
  const int count = index->candidates(sweep, 0, out);
  std::vector<int> found(out.begin(), out.begin() + count);
  for (const int t : boxes_met({mesh.triangles, mesh.x, mesh.x, mesh.x}, sweep, 0))
    EXPECT_TRUE(std::ranges::find(found, t) != found.end());
  EXPECT_TRUE(find_first_contact(*index, {mesh.triangles, x, x}, {}, sweep, {}, out));
}

TEST_P(EveryTriangleIndex, NeedsNoMemoryInTheTick) {
  Sample s{std::mt19937_64(24)};
  const Motion m = random_motion(s);
  index->build(m.triangles, m.x_rest);
  std::vector<int> scratch(m.triangles.size());
  const MovingTriangles surface{m.triangles, m.x_t0, m.x_t1};
  const ToolSweep sweep = random_sweep(s, m);
  int hits = 0;
  EXPECT_EQ(allocations_during([&] {
              for (int i = 0; i < 10; ++i) {
                index->refit(m.x_t0, m.x_t1);
                hits += find_first_contact(*index, surface, {}, sweep, {}, scratch).has_value();
              }
            }),
            0);
}

TEST_P(EveryTriangleIndex, NoTrianglesAreNoCandidates) {
  const VectorX none;
  index->build({}, none);
  index->refit(none, none);
  EXPECT_EQ(index->candidates({{0, 0, 0}, {1, 1, 1}}, 1, {}), 0);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryTriangleIndex, testing::ValuesIn(available_backends()),
                         [](const auto& backend) { return backend.param; });

}  // namespace
}  // namespace kt
