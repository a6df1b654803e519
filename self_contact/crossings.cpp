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

using Pairs = std::map<std::array<int, 2>, Crossing>;

/// Triangles of each edge, by its nodes in ascending order.
class EdgeOwners {
 public:
  explicit EdgeOwners(std::span<const Triangle> triangles) {
    std::vector<std::array<int, 3>> all;  // edge, triangle
    all.reserve(3 * triangles.size());
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
      for (int k = 0; k < 3; ++k) {
        const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        all.push_back({std::min(a, b), std::max(a, b), t});
      }
    std::ranges::sort(all);
    owner_.reserve(all.size());
    for (const auto& [a, b, t] : all) {
      if (edge_.empty() || edge_.back() != std::array{a, b}) {
        edge_.push_back({a, b});
        first_.push_back(owner_.size());
      }
      owner_.push_back(t);
    }
    first_.push_back(owner_.size());
  }
  const std::vector<std::array<int, 2>>& edges() const { return edge_; }
  /// Of the edge with this number.
  std::span<const int> of(std::size_t i) const {
    return std::span(owner_).subspan(first_[i], first_[i + 1] - first_[i]);
  }
  std::span<const int> at(const std::array<int, 2>& edge) const {
    return of(static_cast<std::size_t>(std::ranges::lower_bound(edge_, edge) - edge_.begin()));
  }

 private:
  std::vector<std::array<int, 2>> edge_;  // ascending
  std::vector<std::size_t> first_;
  std::vector<int> owner_;
};

void note(std::span<const int> some, std::span<const int> others, const Vec3& at, bool touches, Pairs& found) {
  for (int a : some)
    for (int b : others) {
      const std::array<int, 2> pair{std::min(a, b), std::max(a, b)};
      found.try_emplace(pair, Crossing{pair, at, touches});
    }
}

/// Of a refit that many queries follow: a tree.
std::string for_many_queries(const std::string& backend) { return backend == "auto" ? "refit_bvh" : backend; }

/// Edges through triangles with which they share no node.
void find_pierced(std::span<const Triangle> triangles, const VectorX& x, const EdgeOwners& owners, TriangleIndex& index,
                  Pairs& found) {
  index.build(triangles, x);
  std::vector<int> near(triangles.size());
  for (std::size_t e = 0; e < owners.edges().size(); ++e) {
    const auto [i, k] = owners.edges()[e];
    const Vec3 p = node(x, i), q = node(x, k);
    const int count = index.candidates({p.cwiseMin(q), p.cwiseMax(q)}, 0, near);
    for (int t : std::span(near).first(static_cast<std::size_t>(count))) {
      const Triangle& v = triangles[t];
      if (std::ranges::find(v, i) != v.end() || std::ranges::find(v, k) != v.end()) continue;
      Vec3 at;
      if (pierces(p, q, node(x, v[0]), node(x, v[1]), node(x, v[2]), at)) note(owners.of(e), {&t, 1}, at, false, found);
    }
  }
}

std::vector<Crossing> listed(const Pairs& found) {
  std::vector<Crossing> out;
  for (const auto& [pair, crossing] : found) out.push_back(crossing);
  return out;
}

}  // namespace

std::vector<Crossing> find_piercings(std::span<const Triangle> triangles, const VectorX& x) {
  Pairs found;
  find_pierced(triangles, x, EdgeOwners(triangles), *make_triangle_index("refit_bvh"), found);
  return listed(found);
}

std::vector<Crossing> find_crossings(SelfContact& contact, std::span<const Triangle> triangles, const VectorX& x) {
  const EdgeOwners of_edge(triangles);
  std::map<int, std::vector<int>> of_node;
  std::map<std::array<int, 3>, std::vector<int>> of_face;
  const auto sorted = [](auto nodes) {
    std::ranges::sort(nodes);
    return nodes;
  };
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    for (const int v : triangles[t]) of_node[v].push_back(t);
    of_face[sorted(std::array{triangles[t][0], triangles[t][1], triangles[t][2]})].push_back(t);
  }
  Pairs found;
  find_pierced(triangles, x, of_edge, *make_triangle_index(for_many_queries(contact.options.backend)), found);
  const double touch = kTouch * contact.barrier.reach;
  for (const SurfacePair& pair : contact.pairs.find(x, x, touch)) {
    if (pair_distance(pair, x).distance > touch) continue;
    const auto& n = pair.nodes;
    if (pair.kind == SurfacePair::Kind::edge_edge)
      note(of_edge.at(sorted(std::array{n[0], n[1]})), of_edge.at(sorted(std::array{n[2], n[3]})), node(x, n[0]), true,
           found);
    else
      note(of_node.at(n[0]), of_face.at(sorted(std::array{n[1], n[2], n[3]})), node(x, n[0]), true, found);
  }
  return listed(found);
}

}  // namespace kt
