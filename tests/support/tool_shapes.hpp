#pragma once
// Tools of the shapes that are more than a point or a sphere.
#include <cmath>

#include "collision/held/moving_tool.hpp"

namespace kt {

/// Surface of a box of these half edges about the origin, `n` x `n` quads a side, rounded by `radius`.
inline ToolShape box_tool(const Vec3& half, int n, double radius) {
  Mesh mesh;
  std::vector<Vec3> nodes;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
          const int first = static_cast<int>(nodes.size());
          for (const auto& [di, dk] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
            Vec3 p;
            p[axis] = side;
            p[(axis + 1) % 3] = 2.0 * (i + di) / n - 1;
            p[(axis + 2) % 3] = 2.0 * (k + dk) / n - 1;
            nodes.push_back(p.cwiseProduct(half));
          }
          const Triangle a{first, first + 1, first + 2}, b{first, first + 2, first + 3};
          mesh.triangles.push_back(side > 0 ? a : Triangle{a[0], a[2], a[1]});
          mesh.triangles.push_back(side > 0 ? b : Triangle{b[0], b[2], b[1]});
        }
  mesh.x.resize(3 * static_cast<Eigen::Index>(nodes.size()));
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) node(mesh.x, i) = nodes[static_cast<std::size_t>(i)];
  return make_mesh_tool(mesh, radius);
}

/// A capsule along y.
inline ToolShape lying_capsule(double radius, double length) {
  ToolShape out = make_capsule(radius, length);
  for (Vec3& corner : out.corners) std::swap(corner.y(), corner.z());
  return out;
}

/// A ball of `rings` x 2 rings quads whose corners lie on a sphere, rounded by `radius`, which the sphere's contains.
inline ToolShape ball_tool(double size, int rings, double radius) {
  Mesh mesh;
  const int around = 2 * rings;
  mesh.x.resize(3 * (2 + (rings - 1) * around));
  const auto at = [&](int ring, int i) {
    return ring == 0 ? 0 : ring == rings ? 1 : 2 + (ring - 1) * around + (i + around) % around;
  };
  for (int ring = 0; ring <= rings; ++ring)
    for (int i = 0; i < around; ++i) {
      const double theta = M_PI * ring / rings, phi = 2 * M_PI * i / around;
      node(mesh.x, at(ring, i)) =
          (size - radius) * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      if (ring == rings) continue;
      if (ring > 0) mesh.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring, i + 1)});
      if (ring + 1 < rings) mesh.triangles.push_back({at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)});
    }
  return make_mesh_tool(mesh, radius);
}

}  // namespace kt
