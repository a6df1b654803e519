#include "collision/shape/tool_features.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace kt {
namespace {

constexpr double kStraight = 1e-10;  // of an edge

bool is_before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// Of each corner the first one, in this order, that is in the same place.
std::vector<int> joined(const std::vector<Vec3>& corners) {
  std::vector<int> order(corners.size()), out(corners.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) { return is_before(corners[a], corners[b]); });
  for (std::size_t i = 0; i < order.size(); ++i)
    out[order[i]] = i > 0 && corners[order[i]] == corners[order[i - 1]] ? out[order[i - 1]] : order[i];
  return out;
}

struct Side {
  int triangle, edge;
};
using EdgeMap = std::map<std::array<int, 2>, std::vector<Side>>;

std::array<int, 2> key(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Two triangles lie in one plane, on both sides of the edge between them.
bool is_flat(const std::vector<Vec3>& x, const Triangle& a, int edge, const Triangle& b, int other) {
  const Vec3 &from = x[a[edge]], along = x[a[(edge + 1) % 3]] - from;
  const Vec3 tip = x[a[(edge + 2) % 3]] - from, tip_b = x[b[(other + 2) % 3]] - from;
  const Vec3 normal = along.cross(tip), across = normal.cross(along);  // across: towards a's tip
  const double size = along.norm() + tip.norm() + tip_b.norm();
  const double area = normal.norm();
  if (!(area > kStraight * size * size)) return false;
  return std::abs(normal.dot(tip_b)) <= kStraight * area * along.norm() && across.dot(tip_b) < 0;
}

bool is_straight(const Vec3& before, const Vec3& at, const Vec3& after) {
  const Vec3 a = at - before, b = after - at;
  const double shorter = std::min(a.norm(), b.norm());
  return a.dot(b) > 0 && a.cross(b).norm() <= kStraight * shorter * std::max(a.norm(), b.norm());
}

}  // namespace

ToolFeatures find_tool_features(const ToolShape& shape) {
  ToolFeatures out;
  if (shape.triangles.empty()) {
    const int count = std::max<int>(1, static_cast<int>(shape.corners.size()));
    for (int i = 0; i < count; ++i) out.corners.push_back(i);
    if (count == 2) out.edges.push_back({0, 1});
    return out;
  }
  const std::vector<Vec3>& x = shape.corners;
  const std::vector<int> join = joined(x);
  std::vector<Triangle> triangles;
  EdgeMap sides;
  for (const Triangle& t : shape.triangles) {
    const Triangle own{join[t[0]], join[t[1]], join[t[2]]};
    for (int c = 0; c < 3; ++c) sides[key(own[c], own[(c + 1) % 3])].push_back({static_cast<int>(triangles.size()), c});
    triangles.push_back(own);
  }

  std::vector<std::vector<int>> next(x.size());  // over the edges that are some
  out.goes_on.resize(triangles.size());
  for (const auto& [ends, of] : sides) {
    const bool goes_on =
        of.size() == 2 && is_flat(x, triangles[of[0].triangle], of[0].edge, triangles[of[1].triangle], of[1].edge);
    for (const Side& side : of)
      if (goes_on) out.goes_on[side.triangle] |= static_cast<unsigned char>(1 << side.edge);
    if (goes_on || ends[0] == ends[1]) continue;
    next[ends[0]].push_back(ends[1]);
    next[ends[1]].push_back(ends[0]);
  }
  std::vector<char> is_used(x.size()), is_within(x.size());  // a triangle's; in a side or along an edge
  for (const Triangle& t : triangles)
    for (const int c : t) is_used[c] = true;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (join[i] != static_cast<int>(i)) continue;
    const std::vector<int>& n = next[i];
    is_within[i] = is_used[i] && (n.empty() || (n.size() == 2 && is_straight(x[n[0]], x[i], x[n[1]])));
    if (!is_within[i]) out.corners.push_back(static_cast<int>(i));
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int c = 0; c < 3; ++c)
      if (next[triangles[t][c]].empty()) out.goes_on[t] |= static_cast<unsigned char>(8 << c);

  for (const int corner : out.corners)
    for (int at : next[corner]) {
      int before = corner;
      while (is_within[at]) before = std::exchange(at, next[at][next[at][0] == before ? 1 : 0]);
      if (corner < at) out.edges.push_back({corner, at});
    }
  std::ranges::sort(out.edges);
  return out;
}

}  // namespace kt
