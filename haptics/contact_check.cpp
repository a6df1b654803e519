#include "haptics/contact_check.hpp"

#include <algorithm>
#include <cmath>

#include "collision/closest_point.hpp"
#include "collision/surface_contacts.hpp"

namespace kt {

double clear_distance(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& centre) {
  double nearest_sq = std::numeric_limits<double>::infinity();
  ClosestPoint nearest;
  int triangle = -1;
  for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t) {
    const Triangle& v = patch.triangles[t];
    const Vec3 a = node(x, v[0]);
    const double extent = std::sqrt(std::max((node(x, v[1]) - a).squaredNorm(), (node(x, v[2]) - a).squaredNorm()));
    const double reach = extent + std::sqrt(nearest_sq);
    if ((centre - a).squaredNorm() > 1.001 * reach * reach) continue;  // all of it is further away
    const ClosestPoint at = closest_point_on_triangle(centre, node(x, v[0]), node(x, v[1]), node(x, v[2]));
    if (at.distance_sq >= nearest_sq) continue;
    nearest_sq = at.distance_sq;
    nearest = at;
    triangle = t;
  }
  if (triangle < 0) return std::numeric_limits<double>::infinity();
  const Triangle& found = patch.triangles[triangle];
  // Inside or outside: by the sum of the face normals around the nearest feature, weighted by the angle it is seen at
  // (Baerentzen and Aanaes 2005), so that an edge or a vertex of any shape decides rightly.
  Vec3 normal = Vec3::Zero();
  for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t) {
    const Triangle& v = patch.triangles[t];
    const auto is_near = [&](int i) { return std::ranges::find(found, i) != found.end(); };
    if (std::ranges::none_of(v, is_near)) continue;
    for (int c = 0; c < 3; ++c) {
      const Vec3 a = node(x, v[c]), b = node(x, v[(c + 1) % 3]), d = node(x, v[(c + 2) % 3]);
      if (nearest.feature == ClosestPoint::Feature::vertex && v[c] == found[nearest.feature_index])
        normal +=
            std::acos(std::clamp((b - a).normalized().dot((d - a).normalized()), -1.0, 1.0)) * face_normal(patch, x, t);
    }
    if (nearest.feature == ClosestPoint::Feature::face && t == triangle) normal = face_normal(patch, x, t);
    if (nearest.feature == ClosestPoint::Feature::edge) {
      const int e0 = found[nearest.feature_index], e1 = found[(nearest.feature_index + 1) % 3];
      if (std::ranges::find(v, e0) != v.end() && std::ranges::find(v, e1) != v.end())
        normal += face_normal(patch, x, t);
    }
  }
  const double distance = std::sqrt(nearest_sq);
  const bool inside = normal.dot(centre - nearest.point) < 0;
  return (inside ? -distance : distance) - tool.radius;
}

double penetration_depth(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& centre) {
  return std::max(0.0, -clear_distance(patch, x, tool, centre));
}

}  // namespace kt
