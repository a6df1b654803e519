#include "io/surface/refine_surface.hpp"

#include <algorithm>
#include <map>

#include "core/base/error.hpp"

namespace kt {
namespace {

struct LongEdge {
  int a = 0, b = 0;
  double length = 0;
};

/// Edges that are too long, the longest first; ties by node, so that the result is one.
std::vector<LongEdge> long_edges(const Mesh& mesh, const SurfaceSize& size) {
  std::vector<LongEdge> out;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (a > b) continue;  // a closed surface has every edge both ways
      const Vec3 middle = 0.5 * (node(mesh.x, a) + node(mesh.x, b));
      const double length = (node(mesh.x, a) - node(mesh.x, b)).norm();
      const double away = std::max(0.0, (middle - size.centre).norm() - 0.5 * length - size.radius);
      if (length > size.edge + size.growth * away) out.push_back({a, b, length});
    }
  std::ranges::sort(out, [](const LongEdge& l, const LongEdge& r) {
    return l.length != r.length ? l.length > r.length : std::pair(l.a, l.b) < std::pair(r.a, r.b);
  });
  return out;
}

/// The triangles on both sides of every edge, by its ends in ascending order.
std::map<std::pair<int, int>, std::vector<int>> triangles_of_edges(const Mesh& mesh) {
  std::map<std::pair<int, int>, std::vector<int>> out;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
    for (int k = 0; k < 3; ++k) out[std::minmax({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]})].push_back(t);
  return out;
}

}  // namespace

Mesh refine_surface(Mesh surface, const SurfaceSize& size, int max_nodes) {
  for (;;) {
    const std::vector<LongEdge> edges = long_edges(surface, size);
    const auto sides = triangles_of_edges(surface);
    std::vector<char> split(surface.triangles.size(), 0);
    std::vector<Vec3> added;
    const int before = surface.num_nodes();
    for (const LongEdge& e : edges) {
      const std::vector<int>& beside = sides.at({e.a, e.b});
      if (std::ranges::any_of(beside, [&](int t) { return split[t] != 0; })) continue;  // in the next pass
      if (before + static_cast<int>(added.size()) >= max_nodes)
        throw RunError(text("the surface would have more than ", max_nodes, " nodes"));
      const int middle = before + static_cast<int>(added.size());
      added.push_back(0.5 * (node(surface.x, e.a) + node(surface.x, e.b)));
      for (int t : beside) {
        split[t] = 1;
        Triangle half = surface.triangles[t];
        std::ranges::replace(half, e.b, middle);
        std::ranges::replace(surface.triangles[t], e.a, middle);
        surface.triangles.push_back(half);
      }
    }
    if (added.empty()) return surface;
    surface.x.conservativeResize(3 * (before + static_cast<int>(added.size())));
    for (std::size_t i = 0; i < added.size(); ++i) node(surface.x, before + static_cast<int>(i)) = added[i];
  }
}

}  // namespace kt
