#include "io/mesh/edge_table.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace kt {

EdgeTable make_edge_table(std::span<const Triangle> triangles) {
  struct Side {
    int a, b;
    EdgeUse use;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    if (repeats_node(triangles[t])) continue;
    for (int k = 0; k < 3; ++k) {
      const int from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), {t, k, from < to}});
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& p, const Side& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
  EdgeTable table;
  table.edge_of.assign(triangles.size(), {-1, -1, -1});
  for (const Side& s : sides) {
    if (table.edges.empty() || table.edges.back().a != s.a || table.edges.back().b != s.b)
      table.edges.push_back({s.a, s.b, static_cast<int>(table.uses.size()), 0});
    ++table.edges.back().count;
    table.uses.push_back(s.use);
    table.edge_of[s.use.triangle][s.use.side] = static_cast<int>(table.edges.size()) - 1;
  }
  return table;
}

bool is_degenerate(const VectorX& x, const Triangle& t) {
  if (repeats_node(t)) return true;
  const Vec3 a = node(x, t[0]), ab = node(x, t[1]) - a, ac = node(x, t[2]) - a;
  const double longest_sq = std::max({ab.squaredNorm(), ac.squaredNorm(), (ab - ac).squaredNorm()});
  constexpr double kRoundoff = 1e-14;  // height over longest edge: a few units in the last place of a coordinate
  return ab.cross(ac).norm() <= kRoundoff * longest_sq;
}

Pieces find_pieces(std::span<const Triangle> triangles, const EdgeTable& table, bool through_nonmanifold) {
  const int n = static_cast<int>(triangles.size());
  Pieces out{0, std::vector<int>(triangles.size(), -1), std::vector<bool>(triangles.size(), false), {}};
  std::vector<int> stack;
  for (int seed = 0; seed < n; ++seed) {
    if (out.piece[seed] >= 0 || table.edge_of[seed][0] < 0) continue;
    out.piece[seed] = out.count;
    out.one_sided.push_back(false);
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (int k = 0; k < 3; ++k) {
        const Edge& e = table.edges[table.edge_of[t][k]];
        if (e.count > 2 && !through_nonmanifold) continue;
        const bool mine = triangles[t][k] == e.a;
        for (const EdgeUse& use : table.uses_of(e)) {
          if (use.triangle == t) continue;
          // Neighbours agree when they run along their edge in opposite directions.
          const bool reversed = out.reversed[t] != (use.forward == mine);
          if (out.piece[use.triangle] < 0) {
            out.piece[use.triangle] = out.count;
            out.reversed[use.triangle] = reversed;
            stack.push_back(use.triangle);
          } else if (e.count == 2 && out.reversed[use.triangle] != reversed) {
            out.one_sided[out.count] = true;
          }
        }
      }
    }
    ++out.count;
  }
  return out;
}

Fans find_fans(std::span<const Triangle> triangles, const EdgeTable& table, int num_nodes) {
  // Union-find over corners: the corners at node v of two triangles that share an edge at v belong to one fan.
  std::vector<int> parent(3 * triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  const auto corner_at = [&](int t, int v) {
    for (int k = 0; k < 3; ++k)
      if (triangles[t][k] == v) return 3 * t + k;
    return -1;
  };
  for (const Edge& e : table.edges) {
    const auto uses = table.uses_of(e);
    for (std::size_t i = 1; i < uses.size(); ++i)
      for (const int v : {e.a, e.b}) {
        const int p = root(corner_at(uses[0].triangle, v)), q = root(corner_at(uses[i].triangle, v));
        parent[std::max(p, q)] = std::min(p, q);
      }
  }
  Fans out{std::vector<int>(static_cast<std::size_t>(num_nodes), 0), std::vector<std::array<int, 3>>(triangles.size())};
  std::vector<int> number(parent.size(), -1);
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      if (table.edge_of[t][k] < 0) continue;
      const int r = root(3 * t + k);
      if (number[r] < 0) number[r] = out.count[triangles[t][k]]++;
      out.fan_of[t][k] = number[r];
    }
  return out;
}

}  // namespace kt
