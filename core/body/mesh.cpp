#include "core/body/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "core/body/embedded_surface.hpp"

namespace kt {

int Mesh::num_own_nodes() const { return embedded ? embedded->first : num_nodes(); }

Bounds bounds(const Mesh& mesh) {
  Bounds b;
  if (mesh.num_nodes() == 0) return b;
  const int first = mesh.embedded ? mesh.embedded->first : 0;
  b.min = b.max = node(mesh.x, first);
  for (int i = first + 1; i < mesh.num_nodes(); ++i) {
    b.min = b.min.cwiseMin(node(mesh.x, i));
    b.max = b.max.cwiseMax(node(mesh.x, i));
  }
  return b;
}

std::vector<Triangle> boundary_triangles(const std::vector<Tetrahedron>& tetrahedra) {
  // Faces of a positive tetrahedron (a b c d), each counter-clockwise seen from outside.
  constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::map<Triangle, std::pair<Triangle, int>> faces;  // ordered, so that the result does not depend on hashing
  for (const Tetrahedron& t : tetrahedra)
    for (const auto& f : kFaces) {
      const Triangle face{t[f[0]], t[f[1]], t[f[2]]};
      Triangle key = face;
      std::sort(key.begin(), key.end());
      auto [it, fresh] = faces.try_emplace(key, face, 0);
      ++it->second.second;
    }
  std::vector<Triangle> out;
  for (const auto& [key, entry] : faces)
    if (entry.second == 1) out.push_back(entry.first);
  return out;
}

double enclosed_volume(const Mesh& mesh) {
  const Vec3 origin = bounds(mesh).centre();  // near the surface: keeps cancellation small for far-off meshes
  double six_volumes = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]) - origin, b = node(mesh.x, t[1]) - origin, c = node(mesh.x, t[2]) - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0;
}

double tetrahedron_volume(const VectorX& x, const Tetrahedron& t) {
  const Vec3 a = node(x, t[0]);
  const Vec3 ab = node(x, t[1]) - a, ac = node(x, t[2]) - a, ad = node(x, t[3]) - a;
  return ab.cross(ac).dot(ad) / 6.0;
}

VectorX node_normals(const VectorX& x, const std::vector<Triangle>& triangles) {
  VectorX n = VectorX::Zero(x.size());
  for (const Triangle& t : triangles) {
    const Vec3 a = node(x, t[0]);
    const Vec3 twice_area = (node(x, t[1]) - a).cross(node(x, t[2]) - a);
    for (int i : t) node(n, i) += twice_area;
  }
  for (int i = 0; i < n.size() / 3; ++i)
    if (const double length = node(n, i).norm(); length > 0) node(n, i) /= length;
  return n;
}

Mesh kuhn_block(int nx, int ny, int nz, double h) {
  const std::array<int, 3> step{1, nx + 1, (nx + 1) * (ny + 1)};
  Mesh mesh;
  mesh.x.resize(3 * (nx + 1) * (ny + 1) * (nz + 1));
  int next = 0;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) node(mesh.x, next++) = h * Vec3(i, j, k);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int corner = i * step[0] + j * step[1] + k * step[2];
        std::array<int, 3> axis{0, 1, 2};
        do {  // one tetrahedron for each order in which a path walks the axes to the far corner
          Tetrahedron t{corner, 0, 0, 0};
          for (int c = 0; c < 3; ++c) t[c + 1] = t[c] + step[axis[c]];
          if (tetrahedron_volume(mesh.x, t) < 0) std::swap(t[1], t[2]);
          mesh.tetrahedra.push_back(t);
        } while (std::next_permutation(axis.begin(), axis.end()));
      }
  mesh.triangles = boundary_triangles(mesh.tetrahedra);
  return mesh;
}

}  // namespace kt
