#include "core/body/surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace kt {
namespace {

constexpr double kGroove = 0.7;  // cosine of the angle between the faces' normals

/// `ridge`: cosine of the least angle of a ridge.
Crease crease_between(std::span<const Triangle> triangles, const VectorX& x, int a, int b, double ridge) {
  const auto area = [&](const Triangle& t) {
    const Vec3 o = node(x, t[0]);
    return Vec3((node(x, t[1]) - o).cross(node(x, t[2]) - o));
  };
  const Vec3 n = area(triangles[a]), m = area(triangles[b]);
  const double turn = n.dot(m), full = n.norm() * m.norm();
  if (!(turn < std::max(kGroove, ridge) * full)) return Crease::none;
  Vec3 from_a_to_b = Vec3::Zero();
  for (int c = 0; c < 3; ++c) from_a_to_b += node(x, triangles[b][c]) - node(x, triangles[a][c]);
  const bool is_concave = n.dot(from_a_to_b) > 0 && m.dot(from_a_to_b) < 0;
  if (is_concave) return turn < kGroove * full ? Crease::groove : Crease::none;
  return turn < ridge * full ? Crease::ridge : Crease::none;
}

/// Which edges are grooves does not depend on the least angle of ridges.
std::vector<std::array<int, 3>> walls_of(std::span<const Triangle> triangles,
                                         const std::vector<std::array<Crease, 3>>& creases,
                                         const SurfaceTopology& topology) {
  std::vector<std::array<bool, 3>> groove;
  groove.reserve(creases.size());
  for (const auto& c : creases)
    groove.push_back({c[0] == Crease::groove, c[1] == Crease::groove, c[2] == Crease::groove});
  return number_walls(triangles, groove, topology);
}

}  // namespace

SurfaceTopology make_topology(std::span<const Triangle> triangles, int num_nodes) {
  SurfaceTopology out;
  TopologyRoom room;
  make_topology(triangles, num_nodes, room, out);
  return out;
}

void TopologyRoom::reserve(std::size_t triangles, std::size_t nodes) {
  next.reserve(nodes);
  edges.reserve(3 * triangles);
}

void make_topology(std::span<const Triangle> triangles, int num_nodes, TopologyRoom& room, SurfaceTopology& out) {
  out.first.assign(static_cast<std::size_t>(num_nodes) + 1, 0);
  for (const Triangle& t : triangles)
    for (int i : t) ++out.first[i + 1];
  for (int i = 0; i < num_nodes; ++i) out.first[i + 1] += out.first[i];
  out.fan.resize(static_cast<std::size_t>(out.first.back()));
  room.next.assign(out.first.begin(), out.first.end() - 1);
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int i : triangles[t]) out.fan[room.next[i]++] = t;

  auto& edges = room.edges;
  edges.clear();
  edges.reserve(3 * triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  const auto key = [](const TopologyRoom::Edge& e) { return std::tie(e.low, e.high, e.triangle); };
  std::sort(edges.begin(), edges.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
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
}

std::vector<std::array<Crease, 3>> find_creases(std::span<const Triangle> triangles, const VectorX& x,
                                                const SurfaceTopology& topology, double ridge_angle) {
  std::vector<std::array<Crease, 3>> out(triangles.size(), {Crease::none, Crease::none, Crease::none});
  const double ridge = std::cos(ridge_angle);
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int c = 0; c < 3; ++c)
      if (const int other = topology.across[t][c]; other >= 0)
        out[t][c] = crease_between(triangles, x, t, other, ridge);
  return out;
}

std::vector<std::array<int, 3>> find_walls(std::span<const Triangle> triangles, const VectorX& x,
                                           const SurfaceTopology& topology) {
  return walls_of(triangles, find_creases(triangles, x, topology, std::numbers::pi), topology);
}

std::vector<std::array<int, 3>> number_walls(std::span<const Triangle> triangles,
                                             std::span<const std::array<bool, 3>> groove,
                                             const SurfaceTopology& topology) {
  std::vector<char> at_groove(topology.first.size(), 0);
  bool any = false;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
    for (int c = 0; c < 3; ++c) {
      if (!groove[t][c]) continue;
      any = true;
      at_groove[triangles[t][c]] = at_groove[triangles[t][(c + 1) % 3]] = 1;
    }
  if (!any) return {};

  std::vector<std::array<int, 3>> wall(triangles.size(), {0, 0, 0});
  const auto corner_at = [&](int t, int v) { return std::ranges::find(triangles[t], v) - triangles[t].begin(); };
  for (int v = 0; v + 1 < static_cast<int>(topology.first.size()); ++v) {
    if (!at_groove[v]) continue;
    const auto fan = topology.triangles_of(v);
    for (int t : fan) wall[t][corner_at(t, v)] = -1;
    int count = 0;
    for (int seed : fan) {
      if (wall[seed][corner_at(seed, v)] >= 0) continue;
      std::vector<int> open{seed};
      wall[seed][corner_at(seed, v)] = count;
      while (!open.empty()) {
        const int t = open.back();
        open.pop_back();
        const auto c = corner_at(t, v);
        for (const auto e : {c, (c + 2) % 3}) {  // the edges at v
          const int other = topology.across[t][e];
          if (other < 0 || groove[t][e] || wall[other][corner_at(other, v)] >= 0) continue;
          wall[other][corner_at(other, v)] = count;
          open.push_back(other);
        }
      }
      ++count;
    }
  }
  return wall;
}

Surface make_surface(const Mesh& mesh, double ridge_angle) {
  Surface out{mesh.triangles, make_topology(mesh.triangles, mesh.num_nodes()), {}, {}, mesh.embedded};
  out.crease = find_creases(out.triangles, mesh.x, out.topology, ridge_angle);
  out.wall = walls_of(out.triangles, out.crease, out.topology);
  return out;
}

}  // namespace kt
