// Every broad phase of the table against brute force, on real meshes: the same candidates and the same first contacts,
// at rest, in motion and where a few vertices move.
#include <gtest/gtest.h>

#include "collision/held/first_contact.hpp"
#include "tests/io/mesh_samples.hpp"
#include "tests/support/triangle_indices.hpp"

namespace kt {
namespace {

class EveryTriangleIndexOnMeshes : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<TriangleIndex> index = make_triangle_index(GetParam());
  std::unique_ptr<TriangleIndex> reference = make_triangle_index("brute_force");
  Sample s{std::mt19937_64(41)};
  std::size_t named = 0, hits = 0;

  void refit_both(const Motion& m) {
    index->refit(m.x_t0, m.x_t1);
    reference->refit(m.x_t0, m.x_t1);
  }

  /// Slow and fast sweeps of a point and of a sphere, near the surface.
  void compare(const Motion& m, double size, int sweeps) {
    const std::vector<unsigned char> none;
    std::vector<int> scratch(m.triangles.size());
    const MovingTriangles surface{m.triangles, m.x_t0, m.x_t1};
    for (int k = 0; k < sweeps; ++k) {
      const auto v = static_cast<int>(s.random() % static_cast<std::size_t>(m.num_vertices()));
      const Vec3 start = node(m.x_t0, v) + 1e-3 * size * s.cube();
      const ToolSweep sweep{start, start + (k % 2 ? 0.3 : 1e-3) * size * s.cube()};
      const ToolShape tool = k % 4 < 2 ? ToolShape{} : ToolShape{ToolShape::Kind::sphere, 0.02 * size};
      const std::vector<int> expected = candidates_of(*reference, sweep, tool.radius, m.triangles.size());
      ASSERT_EQ(candidates_of(*index, sweep, tool.radius, m.triangles.size()), expected) << k;
      const auto contact = find_first_contact(*index, surface, tool, sweep, none, scratch);
      ASSERT_EQ(contact, find_first_contact(*reference, surface, tool, sweep, none, scratch)) << k;
      named += expected.size();
      hits += contact.has_value();
    }
  }

  void compare_on(const Mesh& mesh) {
    Motion m{mesh.triangles, mesh.x, mesh.x, mesh.x};
    const double size = bounds(mesh).size().maxCoeff();
    const int sweeps = m.triangles.size() > 30000 ? 8 : 40;
    index->build(m.triangles, m.x_rest);
    reference->build(m.triangles, m.x_rest);
    compare(m, size, sweeps);
    for (const double way : {1e-4, 0.1}) {
      for (Eigen::Index k = 0; k < m.x_t0.size(); ++k) m.x_t0[k] = m.x_rest[k] + way * size * s.uniform(-1, 1);
      for (Eigen::Index k = 0; k < m.x_t1.size(); ++k) m.x_t1[k] = m.x_t0[k] + 0.1 * way * size * s.uniform(-1, 1);
      refit_both(m);
      compare(m, size, sweeps);
    }
    // The neighbourhood of one vertex after another, as a tool that is dragged over the surface moves it.
    std::vector<int> moved, before;
    for (const std::size_t count : {7u, 19u, 100u}) {
      m.x_t0 = m.x_t1;
      refit_both(m);
      before.clear();
      for (int tick = 0; tick < 4; ++tick) {
        moved.clear();
        for (std::size_t t = s.random() % m.triangles.size(); moved.size() < count && t < m.triangles.size(); ++t)
          moved.insert(moved.end(), m.triangles[t].begin(), m.triangles[t].end());
        for (const int v : before) node(m.x_t0, v) = Vec3(node(m.x_t1, v));
        for (const int v : moved) {
          node(m.x_t0, v) = Vec3(node(m.x_t1, v));
          node(m.x_t1, v) += 0.02 * size * s.cube();
        }
        before.insert(before.end(), moved.begin(), moved.end());
        index->refit_moved(before, m.x_t0, m.x_t1);
        reference->refit(m.x_t0, m.x_t1);
        before = moved;
        compare(m, size, sweeps / 4);
      }
    }
    m.x_t1[3 * m.triangles[0][1]] = std::numeric_limits<double>::quiet_NaN();
    refit_both(m);
    compare(m, size, 4);
  }
};

TEST_P(EveryTriangleIndexOnMeshes, GivesTheCandidatesAndContactsOfBruteForce) {
  std::vector<std::string> files = own_meshes();
  for (const std::string& file : real_meshes()) files.push_back(file);
  int compared = 0;
  for (const std::string& file : files) {
    SCOPED_TRACE(file_name(file));
    Mesh mesh;
    try {
      mesh = load_mesh(file);
    } catch (const InputError&) {
      continue;  // what the reader refuses, its own tests look at
    }
    if (mesh.triangles.empty()) continue;
    ASSERT_NO_FATAL_FAILURE(compare_on(mesh));
    ++compared;
  }
  EXPECT_GE(compared, static_cast<int>(files.size()) - 3);
  EXPECT_GT(named, 1000u);
  EXPECT_GT(hits, 100u);
}

std::vector<std::string> all_but_the_oracle() {
  std::vector<std::string> out = available_triangle_indices();
  std::erase(out, "brute_force");
  return out;
}

INSTANTIATE_TEST_SUITE_P(Table, EveryTriangleIndexOnMeshes, testing::ValuesIn(all_but_the_oracle()),
                         [](const auto& backend) { return backend.param; });

}  // namespace
}  // namespace kt
