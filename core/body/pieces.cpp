#include "core/body/pieces.hpp"

#include <algorithm>
#include <numeric>

namespace kt {

std::vector<int> pieces_of(const Mesh& body, int& count) {
  std::vector<int> parent(static_cast<std::size_t>(body.num_nodes()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<char> used(parent.size(), 0);
  const auto join = [&](const auto& element) {
    for (const int i : element) {
      used[i] = 1;
      parent[root(i)] = root(element[0]);
    }
  };
  for (const Tetrahedron& t : body.tetrahedra) join(t);
  if (body.tetrahedra.empty())
    for (const Triangle& t : body.triangles) join(t);
  std::vector<int> number(parent.size(), -1), out(parent.size(), -1);
  count = 0;
  for (int i = 0; i < body.num_nodes(); ++i) {
    if (!used[i]) continue;
    int& n = number[root(i)];
    if (n < 0) n = count++;
    out[i] = n;
  }
  return out;
}

bool holds_still(const Mesh& body, const std::vector<int>& nodes, double size) {
  if (nodes.size() < 3) return false;
  const Vec3 a = node(body.x, nodes[0]);
  Vec3 along = Vec3::Zero();
  for (const int i : nodes)
    if (const Vec3 d = node(body.x, i) - a; d.norm() > along.norm()) along = d;
  for (const int i : nodes)
    if (along.cross(Vec3(node(body.x, i)) - a).norm() > 1e-4 * size * size) return true;
  return false;
}

std::vector<std::vector<int>> coincident_nodes(const Mesh& body, double tolerance) {
  // In order along a direction that no lattice has, so that few lie within the tolerance of one another there.
  const Vec3 along = Vec3(0.5411961, 0.3826834, 0.7487812).normalized();
  std::vector<std::pair<double, int>> order;
  for (int i = 0; i < body.num_nodes(); ++i)
    if (const Vec3 p = node(body.x, i); p.allFinite()) order.emplace_back(along.dot(p), i);
  std::sort(order.begin(), order.end());
  std::vector<char> taken(static_cast<std::size_t>(body.num_nodes()), 0);
  std::vector<std::vector<int>> out;
  for (auto first = order.begin(); first != order.end(); ++first) {
    if (taken[first->second]) continue;
    std::vector<int> group{first->second};
    const Vec3 place = node(body.x, first->second);
    const double rounding = 1e-14 * place.lpNorm<1>();
    for (auto other = first + 1; other != order.end() && other->first <= first->first + tolerance + rounding; ++other)
      if (!taken[other->second] && (node(body.x, other->second) - place).norm() <= tolerance) {
        group.push_back(other->second);
        taken[other->second] = 1;
      }
    if (group.size() < 2) continue;
    std::sort(group.begin(), group.end());
    out.push_back(std::move(group));
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace kt
