#include "self_contact/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "collision/held/pair_distance.hpp"

namespace kt {
namespace {

constexpr double kTouch = 1e-6;      // of the reach
constexpr double kRounding = 1e-13;  // of the size cubed: a triple product's, and far below what counts as a touch

/// Six times the signed volume.
double orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Where the segment p q goes through the triangle. Not what rounding alone would decide: through its border or in its
/// plane they touch, if anything.
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c, Vec3& at) {
  const double size = std::max({(q - p).norm(), (b - a).norm(), (c - b).norm(), (a - c).norm()});
  const double rounding = kRounding * size * size * size;
  const double below = orientation(a, b, c, p), above = orientation(a, b, c, q);
  if (std::min(std::abs(below), std::abs(above)) <= rounding || (below > 0) == (above > 0)) return false;
  const double ab = orientation(p, q, a, b), bc = orientation(p, q, b, c), ca = orientation(p, q, c, a);
  if (std::min({ab, bc, ca}) < rounding && std::max({ab, bc, ca}) > -rounding) return false;
  at = p + below / (below - above) * (q - p);
  return true;
}

}  // namespace

std::vector<Crossing> find_crossings(SelfContact& contact, std::span<const Triangle> triangles, const VectorX& x) {
  std::map<std::vector<int>, std::vector<int>> owners;  // of a node, an edge or a face, by its nodes: triangles
  const auto sorted = [](std::vector<int> nodes) {
    std::ranges::sort(nodes);
    return nodes;
  };
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    const auto& [a, b, c] = triangles[t];
    for (const auto& feature : {std::vector{a}, {b}, {c}, {a, b}, {b, c}, {c, a}, {a, b, c}})
      owners[sorted(feature)].push_back(t);
  }
  std::map<std::array<int, 2>, Vec3> found;
  const auto note = [&](const std::vector<int>& some, const std::vector<int>& others, const Vec3& at) {
    for (int a : some)
      for (int b : others) found.try_emplace({std::min(a, b), std::max(a, b)}, at);
  };

  const auto index = make_triangle_index(contact.options.backend);
  index->build(triangles, x);
  std::vector<int> near(triangles.size());
  for (const auto& [i, k] : contact.pairs.edges()) {
    const Vec3 p = node(x, i), q = node(x, k);
    const int count = index->candidates({p.cwiseMin(q), p.cwiseMax(q)}, 0, near);
    for (int t : std::span(near).first(static_cast<std::size_t>(count))) {
      const Triangle& v = triangles[t];
      if (std::ranges::find(v, i) != v.end() || std::ranges::find(v, k) != v.end()) continue;
      Vec3 at;
      if (pierces(p, q, node(x, v[0]), node(x, v[1]), node(x, v[2]), at)) note(owners[{i, k}], {t}, at);
    }
  }
  const double touch = kTouch * contact.barrier.reach;
  for (const SurfacePair& pair : contact.pairs.find(x, x, touch)) {
    if (pair_distance(pair, x).distance > touch) continue;
    const auto& n = pair.nodes;
    if (pair.kind == SurfacePair::Kind::edge_edge)
      note(owners[sorted({n[0], n[1]})], owners[sorted({n[2], n[3]})], node(x, n[0]));
    else
      note(owners[{n[0]}], owners[sorted({n[1], n[2], n[3]})], node(x, n[0]));
  }
  std::vector<Crossing> out;
  for (const auto& [pair, at] : found) out.push_back({pair, at});
  return out;
}

}  // namespace kt
