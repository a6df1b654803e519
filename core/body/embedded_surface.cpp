#include "core/body/embedded_surface.hpp"

#include <numeric>

#include "core/body/cut_tetrahedron.hpp"
#include "core/body/node_weights.hpp"

namespace kt {
namespace {

void add_if_any(int node, double weight, NodeWeights& out) {
  if (weight != 0) out.add(node, weight);
}

void keep_different(std::vector<int>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

NodeWeights EmbeddedSurface::carried_by(int vertex) const {
  const auto v = static_cast<std::size_t>(vertex);
  const std::array<int, 4>& corner = corners[v];
  const std::array<double, 4>& w = weights[v];
  NodeWeights out;
  if (!is_quadratic()) {
    for (std::size_t c = 0; c < 4; ++c) add_if_any(corner[c], w[c], out);
    return out;
  }
  const std::array<int, 6>& middle = middles[static_cast<std::size_t>(cell[v])];
  for (std::size_t c = 0; c < 4; ++c) add_if_any(corner[c], w[c] * (2 * w[c] - 1), out);
  for (std::size_t e = 0; e < 6; ++e)
    add_if_any(middle[e],
               4 * w[static_cast<std::size_t>(kCellEdges[e][0])] * w[static_cast<std::size_t>(kCellEdges[e][1])], out);
  return out;
}

void EmbeddedSurface::follow(VectorX& x) const {
  for (int v = 0; v < num_vertices(); ++v) {
    if (is_quadratic()) {
      node(x, first + v) = carried_by(v).of(x);
      continue;
    }
    const auto i = static_cast<std::size_t>(v);
    Vec3 sum = Vec3::Zero();
    for (std::size_t c = 0; c < 4; ++c) sum += weights[i][c] * node(x, corners[i][c]);
    node(x, first + v) = sum;
  }
}

void EmbeddedSurface::group_triangles(const std::vector<Triangle>& triangles) {
  // Cells in the order of their corners; triangles of each stay in order.
  std::vector<int> some_vertex(share.size(), -1), cells, rank(share.size(), 0);
  for (int v = 0; v < num_vertices(); ++v) some_vertex[static_cast<std::size_t>(cell[static_cast<std::size_t>(v)])] = v;
  for (std::size_t c = 0; c < share.size(); ++c)
    if (some_vertex[c] >= 0) cells.push_back(static_cast<int>(c));
  std::ranges::sort(cells, {},
                    [&](int c) { return corners[static_cast<std::size_t>(some_vertex[static_cast<std::size_t>(c)])]; });
  for (std::size_t r = 0; r < cells.size(); ++r) rank[static_cast<std::size_t>(cells[r])] = static_cast<int>(r);
  const auto cell_of = [&](int t) {
    const int vertex = triangles[static_cast<std::size_t>(t)][0] - first;
    return static_cast<std::size_t>(rank[static_cast<std::size_t>(cell[static_cast<std::size_t>(vertex)])]);
  };
  groups = {};
  std::vector<std::size_t> next(cells.size() + 1, 0);
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) ++next[cell_of(t) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  groups.triangle.resize(triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) groups.triangle[next[cell_of(t)]++] = t;
  for (std::size_t i = 0, end = 0; i < triangles.size(); i = end) {
    std::vector<int> met, nodes;
    for (; end < triangles.size() && cell_of(groups.triangle[end]) == cell_of(groups.triangle[i]); ++end)
      for (const int v : triangles[static_cast<std::size_t>(groups.triangle[end])])
        met.push_back(cell[static_cast<std::size_t>(v - first)]);
    keep_different(met);
    for (const int c : met) {
      const auto& of_cell = corners[static_cast<std::size_t>(some_vertex[static_cast<std::size_t>(c)])];
      nodes.insert(nodes.end(), of_cell.begin(), of_cell.end());
      if (!is_quadratic()) continue;
      const auto& middle = middles[static_cast<std::size_t>(c)];
      nodes.insert(nodes.end(), middle.begin(), middle.end());
    }
    keep_different(nodes);
    groups.node.insert(groups.node.end(), nodes.begin(), nodes.end());
    groups.first_node.push_back(static_cast<int>(groups.node.size()));
    groups.first_triangle.push_back(static_cast<int>(end));
  }
}

NodeWeights EmbeddedSurface::moved_by(const std::array<int, 3>& triangle, const Vec3& bary) const {
  NodeWeights out;
  for (int k = 0; k < 3; ++k) {
    const NodeWeights its = carried_by(triangle[static_cast<std::size_t>(k)] - first);
    for (int c = 0; c < its.count; ++c) {
      const double weight = bary[k] * its.weight[static_cast<std::size_t>(c)];
      if (weight == 0) continue;
      const int i = its.node[static_cast<std::size_t>(c)];
      const auto begin = out.node.begin(), end = begin + out.count;
      if (const auto known = std::find(begin, end, i); known != end)
        out.weight[static_cast<std::size_t>(known - begin)] += weight;
      else
        out.add(i, weight);
    }
  }
  return out;
}

}  // namespace kt
