// What the readers of tetrahedral files share.
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "io/mesh_formats.hpp"

namespace kt {

int drop_unused_nodes(Mesh& mesh) {
  std::vector<int> new_node(static_cast<std::size_t>(mesh.num_nodes()), -1);
  for (const Triangle& t : mesh.triangles)
    for (const int i : t) new_node[i] = 0;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const int i : t) new_node[i] = 0;
  int kept = 0;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (new_node[i] == 0) {
      const Vec3 p = node(std::as_const(mesh.x), i);
      node(mesh.x, kept) = p;
      new_node[i] = kept++;
    }
  const int dropped = mesh.num_nodes() - kept;
  mesh.x.conservativeResize(3 * kept);
  for (Triangle& t : mesh.triangles)
    for (int& i : t) i = new_node[i];
  for (Tetrahedron& t : mesh.tetrahedra)
    for (int& i : t) i = new_node[i];
  return dropped;
}

void finish_solid(Mesh& mesh, const std::string& path, const LoadOptions& options, Notes& notes) {
  int turned = 0, flat = 0, first_flat = -1;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    Tetrahedron& t = mesh.tetrahedra[i];
    const double volume = tetrahedron_volume(mesh.x, t);
    if (volume < 0) {
      std::swap(t[2], t[3]);
      ++turned;
    } else if (!(volume > 0) && flat++ == 0) {
      first_flat = static_cast<int>(i);
    }
  }
  if (flat > 0 && !options.lenient) {
    const Vec3 p = node(mesh.x, mesh.tetrahedra[first_flat][0]);
    throw InputError(text(path, ": ", flat, " tetrahedra have no volume, the first is number ", first_flat,
                          " (counted from 0) at (", p[0], ", ", p[1], ", ", p[2], ")"));
  }
  if (turned > 0)
    notes.push_back(text(turned, " of ", mesh.tetrahedra.size(), " tetrahedra turned to positive volume"));
  mesh.triangles = boundary_triangles(mesh.tetrahedra);
  if (options.lenient) return;
  if (const int dropped = drop_unused_nodes(mesh); dropped > 0)
    notes.push_back(text(dropped, " nodes that no tetrahedron uses dropped"));
}

}  // namespace kt
