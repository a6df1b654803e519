#include "haptics/tick/contact_check.hpp"

#include <algorithm>
#include <cmath>

#include "collision/held/moving_tool.hpp"
#include "collision/held/surface_contacts.hpp"
#include "collision/shape/closest_point.hpp"

namespace kt {
namespace {

constexpr double kAsNear = 1e-3;  // of the distance

ClosestPoint closest_on(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& p) {
  const Triangle& v = patch.triangles[triangle];
  return closest_point_on_triangle(p, node(x, v[0]), node(x, v[1]), node(x, v[2]));
}

/// Whether p is on the outer side of what is nearest to it on a triangle: by the sum of the face normals around that,
/// weighted by the angle it is seen at (Baerentzen and Aanaes 2005), so that an edge or a vertex of any shape decides
/// rightly. A triangle without area has no side.
bool is_in_front(const SurfacePatch& patch, const VectorX& x, int triangle, const ClosestPoint& at, const Vec3& p) {
  const Vec3 offset = p - at.point;
  if (at.feature == ClosestPoint::Feature::face) return face_normal(patch, x, triangle).dot(offset) > 0;
  const Triangle& own = patch.triangles[triangle];
  const int first = own[at.feature_index], second = own[(at.feature_index + 1) % 3];
  Vec3 normal = Vec3::Zero();
  for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t) {
    const Triangle& v = patch.triangles[t];
    const auto corner = static_cast<std::size_t>(std::ranges::find(v, first) - v.begin());
    if (corner == 3) continue;
    if (at.feature == ClosestPoint::Feature::edge) {
      if (std::ranges::find(v, second) != v.end()) normal += face_normal(patch, x, t);
      continue;
    }
    const Vec3 a = node(x, first), b = node(x, v[(corner + 1) % 3]), c = node(x, v[(corner + 2) % 3]);
    normal +=
        std::acos(std::clamp((b - a).normalized().dot((c - a).normalized()), -1.0, 1.0)) * face_normal(patch, x, t);
  }
  return normal.dot(offset) > 0;
}

/// Distance of a ball from the surface; negative inside.
double ball_distance(const SurfacePatch& patch, const VectorX& x, double radius, const Vec3& centre) {
  double nearest_sq = std::numeric_limits<double>::infinity();
  ClosestPoint nearest;
  int triangle = -1;
  const auto visit_within = [&](double share, const auto& visit) {  // of the least distance that is known
    for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t) {
      const Triangle& v = patch.triangles[t];
      const Vec3 a = node(x, v[0]);
      const double extent_sq = std::max((node(x, v[1]) - a).squaredNorm(), (node(x, v[2]) - a).squaredNorm());
      const double away_sq = (centre - a).squaredNorm();
      if (away_sq > 2.002 * (extent_sq + share * share * nearest_sq)) continue;  // at least as much as below
      const double reach = std::sqrt(extent_sq) + share * std::sqrt(nearest_sq);
      if (away_sq > 1.001 * reach * reach) continue;  // all of it is further away
      if (visit(t, closest_on(patch, x, t, centre))) return true;
    }
    return false;
  };
  visit_within(1, [&](int t, const ClosestPoint& at) {
    if (at.distance_sq < nearest_sq) {
      nearest_sq = at.distance_sq;
      nearest = at;
      triangle = t;
    }
    return false;
  });
  if (triangle < 0) return std::numeric_limits<double>::infinity();
  // Where the body is folded over, an edge that hangs upside down can be nearest by a rounding, beside faces that the
  // ball rests on. From inside nothing that is as near shows its face.
  const double as_near_sq = std::pow(1 + kAsNear, 2) * nearest_sq;
  const bool is_outside =
      is_in_front(patch, x, triangle, nearest, centre) || visit_within(1 + kAsNear, [&](int t, const ClosestPoint& at) {
        return at.distance_sq <= as_near_sq && is_in_front(patch, x, t, at, centre);
      });
  const double distance = std::sqrt(nearest_sq);
  return (is_outside ? distance : -distance) - radius;
}

/// Where the segment a b goes through the triangle, unless they are parallel.
bool is_pierced(const Vec3& a, const Vec3& b, const Vec3 (&t)[3]) {
  const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  if (!(volume(t[0], t[1], t[2], a) * volume(t[0], t[1], t[2], b) < 0)) return false;
  const double u = volume(a, b, t[0], t[1]), v = volume(a, b, t[1], t[2]), w = volume(a, b, t[2], t[0]);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// Distance of the segments, by sampling one and refining where it is least: the distance from the other is convex.
double segment_distance(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto from_other = [&](double s) {
    const Vec3 p = a + s * (b - a), along = d - c;
    const double u = std::clamp(along.dot(p - c) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    return (p - c - u * along).norm();
  };
  double low = 0, high = 1;
  for (int i = 0; i < 80; ++i) {
    const double s = low + (high - low) / 3, t = high - (high - low) / 3;
    (from_other(s) < from_other(t) ? high : low) = from_other(s) < from_other(t) ? t : s;
  }
  return from_other(0.5 * (low + high));
}

}  // namespace

double clear_distance(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& centre) {
  return ball_distance(patch, x, tool.radius, centre);
}

double penetration_depth(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& place,
                         const Quaternion& turn) {
  if (tool.corners.empty()) return std::max(0.0, -ball_distance(patch, x, tool.radius, place));
  std::vector<Vec3> corners;
  for (const Vec3& corner : tool.corners) corners.push_back(place + turn * corner);
  MovingTool moving(tool);
  moving.move({place, place, turn, turn});
  const double r = tool.radius;
  Box patch_box{node(x, 0), node(x, 0)};
  for (int i = 1; i < patch.num_vertices(); ++i) {
    patch_box.low = patch_box.low.cwiseMin(Vec3(node(x, i)));
    patch_box.high = patch_box.high.cwiseMax(Vec3(node(x, i)));
  }
  patch_box.low.array() -= r;
  patch_box.high.array() += r;
  double depth = 0;
  for (const Vec3& corner : corners)
    if (!is_apart(patch_box, {corner, corner})) depth = std::max(depth, -ball_distance(patch, x, r, corner));
  for (const Triangle& v : patch.triangles) {
    const Vec3 t[3] = {node(x, v[0]), node(x, v[1]), node(x, v[2])};
    const Box box{t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() - r, t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() + r};
    for (const auto& [i, k] : moving.core().edges) {
      const Vec3 &a = corners[i], &b = corners[k];
      if (is_apart(box, {a.cwiseMin(b), a.cwiseMax(b)})) continue;
      if (is_pierced(a, b, t)) depth = std::max(depth, r);
      for (int c = 0; c < 3; ++c) depth = std::max(depth, r - segment_distance(a, b, t[c], t[(c + 1) % 3]));
    }
    for (const Triangle& face : tool.triangles)
      for (const Vec3& p : t) {
        const Vec3 &a = corners[face[0]], &b = corners[face[1]], &c = corners[face[2]];
        if (is_apart({p.array() - r, p.array() + r}, {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)})) continue;
        depth = std::max(depth, r - std::sqrt(closest_point_on_triangle(p, a, b, c).distance_sq));
      }
  }
  return depth;
}

}  // namespace kt
