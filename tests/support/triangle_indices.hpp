#pragma once
// What the tests of all broad phases share: the table, motions to follow, and the answer by definition.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "collision/broad/triangle_index.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {

inline std::vector<std::string> available_triangle_indices() {
  std::vector<std::string> out;
  for (const BackendInfo& b : triangle_index_backends())
    if (b.available) out.push_back(b.name);
  return out;
}

struct Motion {
  std::vector<Triangle> triangles;
  VectorX x_rest, x_t0, x_t1;
  int num_vertices() const { return static_cast<int>(x_rest.size() / 3); }
};

/// A sheet, or a soup with duplicated and degenerate triangles, far from the origin now and then, that has moved since
/// the build: a little, or far.
inline Motion random_motion(Sample& s) {
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
    m.triangles.insert(m.triangles.end(), 3, m.triangles[7]);
    m.triangles.insert(m.triangles.end(), 2, {5, 5, 5});
    m.triangles.push_back({1, 2, 1});
  }
  for (int i = 0; i < m.num_vertices(); ++i) node(m.x_rest, i) += centre;
  m.x_t0 = m.x_rest;
  m.x_t1 = m.x_rest;
  for (int i = 0; i < m.num_vertices(); ++i) {
    node(m.x_t0, i) += moved * s.cube();
    node(m.x_t1, i) = Vec3(node(m.x_t0, i)) + 0.3 * moved * s.cube();
  }
  return m;
}

inline ToolSweep random_sweep(Sample& s, const Motion& m) {
  const Vec3 near = node(m.x_t0, static_cast<int>(s.random() % static_cast<std::size_t>(m.num_vertices())));
  const double size = (m.x_t0.maxCoeff() - m.x_t0.minCoeff()) * 0.3;
  return {near + size * s.cube(), near + size * s.cube()};
}

/// By definition: the swept boxes that the box of the path, grown by the margin, meets. A triangle with a vertex that
/// is not finite is everywhere.
inline std::vector<int> boxes_met(const Motion& m, const ToolSweep& sweep, double margin) {
  std::vector<int> out;
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    bool apart = false, somewhere = true;
    for (int axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const int v : m.triangles[t])
        for (const double x : {m.x_t0[3 * v + axis], m.x_t1[3 * v + axis]}) {
          low = std::min(low, x);
          high = std::max(high, x);
          somewhere = somewhere && std::isfinite(x);
        }
      apart = apart || low > std::max(sweep.x_t0[axis], sweep.x_t1[axis]) + margin ||
              high < std::min(sweep.x_t0[axis], sweep.x_t1[axis]) - margin;
    }
    if (!apart || !somewhere) out.push_back(static_cast<int>(t));
  }
  return out;
}

/// The candidates as a list of their own.
inline std::vector<int> candidates_of(const TriangleIndex& index, const ToolSweep& sweep, double margin,
                                      std::size_t num_triangles) {
  std::vector<int> out(num_triangles, -1);
  out.resize(static_cast<std::size_t>(index.candidates(sweep, margin, out)));
  return out;
}

}  // namespace kt
