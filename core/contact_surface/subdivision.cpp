#include "core/contact_surface/subdivision.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace kt {
namespace {

constexpr int kMostNeighbours = 10;  // a vertex with more stays where it is: it would couple too many nodes

using Row = std::map<int, double>;  // weights of the vertices that all was made of

struct Edge {
  int low = 0, high = 0;
  std::vector<std::pair<int, int>> sides;  // triangle, corner opposite
  bool sharp = false;
};

struct Level {
  std::vector<Triangle> triangles;
  std::vector<std::array<bool, 3>> sharp;
  std::vector<Row> rows;                     // of each vertex
  std::vector<Edge> edges;                   // of these triangles
  std::vector<std::array<int, 3>> edge_of;   // edge (v[i], v[i+1]) of each triangle
  std::vector<std::vector<int>> neighbours;  // of each vertex, in no order
  std::vector<std::vector<int>> sharp_to;    // those over sharp edges
};

void find_edges(Level& level) {
  std::map<std::pair<int, int>, int> known;
  level.edges.clear();
  level.edge_of.assign(level.triangles.size(), {});
  const auto n = level.rows.size();
  for (int t = 0; t < static_cast<int>(level.triangles.size()); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = level.triangles[t][c], b = level.triangles[t][(c + 1) % 3];
      const auto [at, is_new] =
          known.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(level.edges.size()));
      if (is_new) level.edges.push_back({std::min(a, b), std::max(a, b), {}, false});
      Edge& edge = level.edges[at->second];
      edge.sides.emplace_back(t, (c + 2) % 3);
      edge.sharp = edge.sharp || level.sharp[t][c];
      level.edge_of[t][c] = at->second;
    }
  level.neighbours.assign(n, {});
  level.sharp_to.assign(n, {});
  for (Edge& edge : level.edges) {
    edge.sharp = edge.sharp || edge.sides.size() != 2;
    level.neighbours[edge.low].push_back(edge.high);
    level.neighbours[edge.high].push_back(edge.low);
    if (!edge.sharp) continue;
    level.sharp_to[edge.low].push_back(edge.high);
    level.sharp_to[edge.high].push_back(edge.low);
  }
}

void add(Row& to, double weight, const Row& row) {
  for (const auto& [from, value] : row) to[from] += weight * value;
}

enum class VertexKind { smooth, crease, corner };

VertexKind kind_of(const Level& level, int v) {
  if (level.neighbours[v].empty() || level.neighbours[v].size() > kMostNeighbours) return VertexKind::corner;
  const auto sharp = level.sharp_to[v].size();
  return sharp == 0 ? VertexKind::smooth : sharp == 2 ? VertexKind::crease : VertexKind::corner;
}

/// (1 - share) of the vertex itself and the rest evenly of its neighbours.
Row mean_with(const Level& level, int v, double share, const std::vector<int>& neighbours) {
  Row out;
  add(out, 1 - share, level.rows[v]);
  for (const int i : neighbours) add(out, share / static_cast<double>(neighbours.size()), level.rows[i]);
  return out;
}

double loop_share(std::size_t neighbours) {
  const double c = 3.0 / 8 + std::cos(2 * std::numbers::pi / static_cast<double>(neighbours)) / 4;
  return 5.0 / 8 - c * c;
}

Row loop_vertex(const Level& level, int v) {
  switch (kind_of(level, v)) {
    case VertexKind::corner:
      return level.rows[v];
    case VertexKind::crease:
      return mean_with(level, v, 1.0 / 4, level.sharp_to[v]);
    default:
      return mean_with(level, v, loop_share(level.neighbours[v].size()), level.neighbours[v]);
  }
}

/// Where endless refinement takes the vertex: the eigenvector of its ring's refinement.
Row loop_limit(const Level& level, int v) {
  switch (kind_of(level, v)) {
    case VertexKind::corner:
      return level.rows[v];
    case VertexKind::crease:
      return mean_with(level, v, 1.0 / 3, level.sharp_to[v]);
    default: {
      const double share = loop_share(level.neighbours[v].size());
      return mean_with(level, v, share / (3.0 / 8 + share), level.neighbours[v]);
    }
  }
}

Row loop_edge(const Level& level, const Edge& edge) {
  Row out;
  add(out, edge.sharp ? 1.0 / 2 : 3.0 / 8, level.rows[edge.low]);
  add(out, edge.sharp ? 1.0 / 2 : 3.0 / 8, level.rows[edge.high]);
  if (!edge.sharp)
    for (const auto& [t, c] : edge.sides) add(out, 1.0 / 8, level.rows[level.triangles[t][c]]);
  return out;
}

Level refine(const Level& level) {
  Level out;
  const auto n = static_cast<int>(level.rows.size());
  for (int v = 0; v < n; ++v) out.rows.push_back(loop_vertex(level, v));
  for (const Edge& edge : level.edges) out.rows.push_back(loop_edge(level, edge));
  for (std::size_t t = 0; t < level.triangles.size(); ++t) {
    const Triangle& v = level.triangles[t];
    const auto& e = level.edge_of[t];
    const std::array<bool, 3> sharp{level.edges[e[0]].sharp, level.edges[e[1]].sharp, level.edges[e[2]].sharp};
    const int ab = n + e[0], bc = n + e[1], ca = n + e[2];
    out.triangles.insert(out.triangles.end(), {{v[0], ab, ca}, {ab, v[1], bc}, {ca, bc, v[2]}, {ab, bc, ca}});
    out.sharp.insert(
        out.sharp.end(),
        {{sharp[0], false, sharp[2]}, {sharp[0], sharp[1], false}, {false, sharp[1], sharp[2]}, {false, false, false}});
  }
  return out;
}

}  // namespace

Subdivision subdivide_loop(std::span<const Triangle> triangles, int num_vertices,
                           std::span<const std::array<bool, 3>> sharp, int levels) {
  Level level;
  level.triangles.assign(triangles.begin(), triangles.end());
  level.sharp.assign(sharp.begin(), sharp.end());
  for (int v = 0; v < num_vertices; ++v) level.rows.push_back({{v, 1.0}});
  for (int i = 0; i < levels; ++i) {
    find_edges(level);
    level = refine(level);
  }
  find_edges(level);
  Subdivision out;
  out.triangles = level.triangles;
  out.first.push_back(0);
  for (int v = 0; v < static_cast<int>(level.rows.size()); ++v) {
    for (const auto& [from, weight] : loop_limit(level, v)) {
      if (weight == 0) continue;
      out.from.push_back(from);
      out.weight.push_back(weight);
    }
    out.first.push_back(static_cast<int>(out.from.size()));
  }
  return out;
}

}  // namespace kt
