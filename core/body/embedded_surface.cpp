#include "core/body/embedded_surface.hpp"

#include <numeric>

namespace kt {

void EmbeddedSurface::follow(VectorX& x) const {
  for (int v = 0; v < num_vertices(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    Vec3 sum = Vec3::Zero();
    for (std::size_t c = 0; c < 4; ++c) sum += weights[i][c] * node(x, corners[i][c]);
    node(x, first + v) = sum;
  }
}

void EmbeddedSurface::group_triangles(const std::vector<Triangle>& triangles) {
  const auto cell_of = [&](int t) -> const std::array<int, 4>& {
    return corners[static_cast<std::size_t>(triangles[static_cast<std::size_t>(t)][0] - first)];
  };
  groups = {};
  groups.triangle.resize(triangles.size());
  std::iota(groups.triangle.begin(), groups.triangle.end(), 0);
  std::ranges::stable_sort(groups.triangle, {}, cell_of);
  for (std::size_t i = 0, end = 0; i < triangles.size(); i = end) {
    std::vector<int> nodes;
    while (end < triangles.size() && cell_of(groups.triangle[end]) == cell_of(groups.triangle[i])) {
      for (const int v : triangles[static_cast<std::size_t>(groups.triangle[end])]) {
        const auto& of_vertex = corners[static_cast<std::size_t>(v - first)];
        nodes.insert(nodes.end(), of_vertex.begin(), of_vertex.end());
      }
      ++end;
    }
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    groups.node.insert(groups.node.end(), nodes.begin(), nodes.end());
    groups.first_node.push_back(static_cast<int>(groups.node.size()));
    groups.first_triangle.push_back(static_cast<int>(end));
  }
}

NodeWeights EmbeddedSurface::moved_by(const std::array<int, 3>& triangle, const Vec3& bary) const {
  NodeWeights out;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(triangle[static_cast<std::size_t>(k)] - first);
    for (std::size_t c = 0; c < 4; ++c) {
      const double weight = bary[k] * weights[i][c];
      if (weight == 0) continue;
      const auto begin = out.node.begin(), end = begin + out.count;
      if (const auto known = std::find(begin, end, corners[i][c]); known != end)
        out.weight[static_cast<std::size_t>(known - begin)] += weight;
      else
        out.add(corners[i][c], weight);
    }
  }
  return out;
}

}  // namespace kt
