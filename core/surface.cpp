#include "core/surface.hpp"

#include <algorithm>
#include <tuple>

namespace kt {

SurfaceTopology make_topology(std::span<const Triangle> triangles, int num_nodes) {
  SurfaceTopology out;
  out.first.assign(num_nodes + 1, 0);
  for (const Triangle& t : triangles)
    for (int i : t) ++out.first[i + 1];
  for (int i = 0; i < num_nodes; ++i) out.first[i + 1] += out.first[i];
  out.fan.resize(out.first.back());
  std::vector<int> next(out.first.begin(), out.first.end() - 1);
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int i : triangles[t]) out.fan[next[i]++] = t;

  struct Edge {
    int low, high, triangle, corner;
    auto key() const { return std::tie(low, high, triangle); }
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.key() < b.key(); });
  out.across.assign(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    for (std::size_t k = i; k < end; ++k) {
      int& slot = out.across[edges[k].triangle][edges[k].corner];
      slot = end - i == 1 ? -1 : end - i > 2 ? -2 : edges[k == i ? i + 1 : i].triangle;
    }
    i = end;
  }
  return out;
}

}  // namespace kt
