#include "io/mesh/polygon.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/error.hpp"

namespace kt {
namespace {

Vec3 newell_normal(const VectorX& x, std::span<const int> corners) {
  const Vec3 origin = node(x, corners[0]);
  Vec3 n = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = node(x, corners[i]) - origin, b = node(x, corners[(i + 1) % corners.size()]) - origin;
    n += a.cross(b);
  }
  return n;
}

/// Twice the area of (a b c) seen along n; positive at a convex corner b.
double turn(const VectorX& x, const Vec3& n, int a, int b, int c) {
  return n.dot((node(x, b) - node(x, a)).cross(node(x, c) - node(x, b)));
}

bool is_convex(const VectorX& x, const Vec3& n, std::span<const int> p) {
  const std::size_t size = p.size();
  for (std::size_t i = 0; i < size; ++i)
    if (turn(x, n, p[i], p[(i + 1) % size], p[(i + 2) % size]) < 0) return false;
  // Every fan triangle must turn the right way too: a star polygon has only left turns.
  for (std::size_t i = 1; i + 1 < size; ++i)
    if (turn(x, n, p[0], p[i], p[i + 1]) < 0) return false;
  return true;
}

bool inside(const VectorX& x, const Vec3& n, const Triangle& t, int p) {
  return turn(x, n, t[0], t[1], p) >= 0 && turn(x, n, t[1], t[2], p) >= 0 && turn(x, n, t[2], t[0], p) >= 0;
}

/// Corner i turns left, and its triangle holds no other corner.
bool is_ear(const VectorX& x, const Vec3& n, const std::vector<int>& p, std::size_t i) {
  const std::size_t size = p.size();
  const Triangle t{p[(i + size - 1) % size], p[i], p[(i + 1) % size]};
  if (!(turn(x, n, t[0], t[1], t[2]) > 0)) return false;
  for (const int q : p)
    if (q != t[0] && q != t[1] && q != t[2] && inside(x, n, t, q)) return false;
  return true;
}

/// Cuts ears; false when no ear is left before the end (self-crossing or flat polygon), or when there are so many
/// corners that it would take for ever: the time grows with their square.
bool cut_ears(const VectorX& x, const Vec3& n, std::vector<int> p, std::vector<Triangle>& out) {
  if (p.size() > PolygonTriangulator::kMostCorners) return false;
  std::vector<char> ears(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) ears[i] = is_ear(x, n, p, i);
  while (p.size() > 3) {
    const auto found = std::find(ears.begin(), ears.end(), 1);
    if (found == ears.end()) return false;
    const auto at = found - ears.begin();
    const auto ear = static_cast<std::size_t>(at), size = p.size();
    out.push_back({p[(ear + size - 1) % size], p[ear], p[(ear + 1) % size]});
    p.erase(p.begin() + at);
    ears.erase(found);
    // Of a polygon that does not cross itself no others become ears, or cease to be.
    for (const std::size_t i : {ear % p.size(), (ear + p.size() - 1) % p.size()}) ears[i] = is_ear(x, n, p, i);
  }
  out.push_back({p[0], p[1], p[2]});
  return true;
}

}  // namespace

void PolygonTriangulator::add(const VectorX& x, std::span<const int> corners, std::vector<Triangle>& out) {
  if (corners.size() == 3) {
    out.push_back({corners[0], corners[1], corners[2]});
    return;
  }
  ++polygons_;
  const Vec3 n = newell_normal(x, corners);
  if (!is_convex(x, n, corners)) {
    ++concave_;
    const std::size_t before = out.size();
    if (cut_ears(x, n, {corners.begin(), corners.end()}, out)) return;
    ++failed_;
    out.resize(before);
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) out.push_back({corners[0], corners[i], corners[i + 1]});
}

std::vector<std::string> PolygonTriangulator::notes() const {
  std::vector<std::string> out;
  if (polygons_ > 0) out.push_back(text(polygons_, " polygons split into triangles"));
  if (concave_ > 0) out.push_back(text(concave_, " polygons are not convex: split by cutting ears"));
  if (failed_ > 0)
    out.push_back(text(failed_, " polygons cross themselves, are flat or have more than ", kMostCorners,
                       " corners: split as fans"));
  return out;
}

}  // namespace kt
