#include "tests/support/meshes.hpp"

#include <algorithm>

namespace kt {

Mesh one_tetrahedron(double h) {
  Mesh mesh;
  mesh.x = h * VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

Mesh sheet(int nx, int ny, double h) {
  Mesh mesh;
  mesh.x.resize(3 * (nx + 1) * (ny + 1));
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) node(mesh.x, j * (nx + 1) + i) = h * Vec3(i, j, 0);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = j * (nx + 1) + i, b = a + 1, c = a + nx + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
    }
  return mesh;
}

std::vector<int> nodes_below(const Mesh& mesh, double height) {
  std::vector<int> out;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (node(mesh.x, i).z() < height) out.push_back(i);
  return out;
}

}  // namespace kt
