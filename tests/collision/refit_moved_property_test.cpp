// A refit of what moved gives what a refit of everything gives, in every broad phase of the table.
#include <gtest/gtest.h>

#include "tests/support/triangle_indices.hpp"

namespace kt {
namespace {

/// Vertices that differ at either end, in a random order, some of them twice.
std::vector<int> differing(Sample& s, const Motion& before, const Motion& now) {
  std::vector<int> out;
  const auto differs = [](const VectorX& a, const VectorX& b, int v) {
    for (int k = 3 * v; k < 3 * v + 3; ++k)
      if (!(a[k] == b[k])) return true;
    return false;
  };
  for (int v = 0; v < now.num_vertices(); ++v)
    if (differs(before.x_t0, now.x_t0, v) || differs(before.x_t1, now.x_t1, v))
      out.insert(out.end(), 1 + s.random() % 2, v);
  std::shuffle(out.begin(), out.end(), s.random);
  return out;
}

/// Some vertices go on from where they are, some come to rest, now and then one is lost or found again.
void move_some(Sample& s, Motion& m, double share, double way) {
  for (int v = 0; v < m.num_vertices(); ++v) {
    if (s.uniform(0, 1) > share) continue;
    node(m.x_t0, v) = Vec3(node(m.x_t1, v));
    if (s.uniform(0, 1) < 0.3) continue;
    node(m.x_t1, v) += way * s.cube();
    if (s.uniform(0, 1) < 0.02) m.x_t1[3 * v + 1] = std::numeric_limits<double>::quiet_NaN();
    if (!Vec3(node(m.x_t0, v)).allFinite()) node(m.x_t0, v) = node(m.x_t1, v) = Vec3(node(m.x_rest, v));
  }
}

class EveryRefit : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<TriangleIndex> index = make_triangle_index(GetParam());
};

void follow(TriangleIndex& index, Sample& s, Motion m, int rounds, double share) {
  index.build(m.triangles, m.x_rest);
  index.refit(m.x_t0, m.x_t1);
  const double size = (m.x_rest.maxCoeff() - m.x_rest.minCoeff());
  for (int round = 0; round < rounds; ++round) {
    const Motion before = m;
    move_some(s, m, round % 5 ? share : 0, size * std::pow(10, s.uniform(-4, 0)));
    index.refit_moved(differing(s, before, m), m.x_t0, m.x_t1);
    for (int k = 0; k < 4; ++k) {
      ToolSweep sweep = random_sweep(s, m);
      if (!sweep.x_t0.allFinite()) sweep.x_t0 = sweep.x_t1 = node(m.x_rest, 0);
      const double margin = k % 2 ? 0 : 0.01 * size;
      ASSERT_EQ(candidates_of(index, sweep, margin, m.triangles.size()), boxes_met(m, sweep, margin)) << round;
    }
  }
}

TEST_P(EveryRefit, OfWhatMovedIsARefitOfEverything) {
  Sample s{std::mt19937_64(31)};
  for (int i = 0; i < 100; ++i) follow(*index, s, random_motion(s), 20, std::pow(10, s.uniform(-2, 0)));
}

TEST_P(EveryRefit, OfWhatMovedHoldsInADeepTree) {
  Sample s{std::mt19937_64(32)};
  const Mesh mesh = sheet(40, 40, 1e-3);
  follow(*index, s, {mesh.triangles, mesh.x, mesh.x, mesh.x}, GetParam() == "refit_bvh" ? 300 : 30, 0.01);
}

TEST_P(EveryRefit, FollowsASmallMeshAfterALargeOneAndBack) {
  Sample s{std::mt19937_64(33)};
  for (const int cells : {60, 4, 60}) {  // 7200 and 32 triangles
    const Mesh mesh = sheet(cells, cells, 1e-3);
    follow(*index, s, {mesh.triangles, mesh.x, mesh.x, mesh.x}, 10, 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, EveryRefit, testing::ValuesIn(available_triangle_indices()),
                         [](const auto& backend) { return backend.param; });

}  // namespace
}  // namespace kt
