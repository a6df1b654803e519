#include "io/solid/tetrahedra_quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kt {
namespace {

using Corners = std::array<Vec3, 4>;

double radius_over_edge(const Corners& p) {
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], w = p[3] - p[0];
  const Vec3 to_centre = (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u) + w.squaredNorm() * u.cross(v)) /
                         (2 * u.dot(v.cross(w)));
  double shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) shortest = std::min(shortest, (p[i] - p[j]).norm());
  return to_centre.norm() / shortest;
}

/// Angle between the two faces that share edge (a b) [degrees].
double dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 axis = (b - a).normalized();
  const Vec3 p = (c - a) - axis * axis.dot(c - a), q = (d - a) - axis * axis.dot(d - a);
  return std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::numbers::pi;
}

}  // namespace

TetrahedraQuality tetrahedra_quality(const Mesh& solid) {
  TetrahedraQuality q;
  if (solid.tetrahedra.empty()) return q;
  q.volume_min = std::numeric_limits<double>::infinity();
  q.dihedral_min = 180;
  constexpr int kEdges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
  for (const Tetrahedron& t : solid.tetrahedra) {
    const Corners p{node(solid.x, t[0]), node(solid.x, t[1]), node(solid.x, t[2]), node(solid.x, t[3])};
    const double volume = tetrahedron_volume(solid.x, t);
    q.volume += volume;
    q.volume_min = std::min(q.volume_min, volume);
    q.radius_edge_max = std::max(q.radius_edge_max, radius_over_edge(p));
    for (const auto& e : kEdges)
      q.dihedral_min = std::min(q.dihedral_min, dihedral(p[e[0]], p[e[1]], p[e[2]], p[e[3]]));
  }
  return q;
}

}  // namespace kt
