#pragma once
// Whole closed meshes as the patch that contact finding works on, and what brute force says about them.
#include <cmath>
#include <limits>

#include "collision/held/surface_contacts.hpp"
#include "collision/shape/closest_point.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {

struct TestSurface {
  SurfacePatch patch;
  VectorX x;
};

inline TestSurface make_test_surface(std::vector<Triangle> triangles, VectorX x) {
  TestSurface out;
  const auto n = static_cast<int>(x.size() / 3);
  out.patch.topology = make_topology(triangles, n);
  out.patch.wall = find_walls(triangles, x, out.patch.topology);
  out.patch.triangles = std::move(triangles);
  out.patch.global_node.resize(static_cast<std::size_t>(n));
  out.x = std::move(x);
  return out;
}

inline TestSurface load_test_surface(const std::string& name) {
  Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/" + name);
  return make_test_surface(mesh.triangles, mesh.x);
}

inline ClosestPoint closest_on(const TestSurface& s, int triangle, const Vec3& p) {
  const Triangle& t = s.patch.triangles[static_cast<std::size_t>(triangle)];
  return closest_point_on_triangle(p, node(s.x, t[0]), node(s.x, t[1]), node(s.x, t[2]));
}

/// Distance to the nearest of all triangles.
inline double distance_to(const TestSurface& s, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(s.patch.triangles.size()); ++t)
    best = std::min(best, closest_on(s, t, p).distance_sq);
  return std::sqrt(best);
}

/// How often the closed surface winds around p: 1 inside, 0 outside (solid angles, van Oosterom and Strackee 1983).
inline double winding_number(const TestSurface& s, const Vec3& p) {
  double angle = 0;
  for (const Triangle& t : s.patch.triangles) {
    const Vec3 a = Vec3(node(s.x, t[0])) - p, b = Vec3(node(s.x, t[1])) - p, c = Vec3(node(s.x, t[2])) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * std::acos(-1.0));
}

}  // namespace kt
