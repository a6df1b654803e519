// What the readers of tetrahedral files share.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/error.hpp"
#include "io/mesh/mesh_formats.hpp"

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

namespace {

/// Second copies of a tetrahedron, whatever the order of its nodes: the body would be twice as stiff and heavy there,
/// and faces between two copies would be found four times and cut the surface open. Returns how many went.
int drop_doubled(std::vector<Tetrahedron>& tetrahedra) {
  std::set<Tetrahedron> known;
  return static_cast<int>(std::erase_if(tetrahedra, [&](Tetrahedron t) {
    std::sort(t.begin(), t.end());
    return !known.insert(t).second;
  }));
}

}  // namespace

void finish_solid(Mesh& mesh, const std::string& path, const LoadOptions& options, Notes& notes) {
  const std::size_t given = mesh.tetrahedra.size();
  if (const int doubled = drop_doubled(mesh.tetrahedra); doubled > 0)
    notes.push_back(text(doubled, " of ", given,
                         " tetrahedra were there before, over the same nodes (as Gmsh 2.2 saves ",
                         "an element once for each of its groups): taken once"));
  int turned = 0, flat = 0, first_flat = -1;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    Tetrahedron& t = mesh.tetrahedra[i];
    const bool is_turned = tetrahedron_volume(mesh.x, t) < 0;
    if (is_turned) std::swap(t[2], t[3]);
    const bool is_flat = !(tetrahedron_volume(mesh.x, t) > 0);  // also where rounding decides: negative both ways round
    turned += is_turned && !is_flat;
    if (is_flat && flat++ == 0) first_flat = static_cast<int>(i);
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

namespace {

constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // opposite to corner 0..3, outward

struct Face {
  Triangle key;  ///< ascending nodes
  int tetrahedron;
  bool operator<(const Face& o) const { return key != o.key ? key < o.key : tetrahedron < o.tetrahedron; }
};

/// Region number of every tetrahedron; regions end at the triangles of the surface.
std::vector<int> find_regions(const Mesh& solid, const std::set<Triangle>& walls, int& count) {
  std::vector<Face> faces;
  for (int i = 0; i < static_cast<int>(solid.tetrahedra.size()); ++i)
    for (const auto& f : kFaces) {
      const Tetrahedron& t = solid.tetrahedra[i];
      Face face{{t[f[0]], t[f[1]], t[f[2]]}, i};
      std::sort(face.key.begin(), face.key.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  std::vector<int> parent(solid.tetrahedra.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].key == faces[i - 1].key && !walls.count(faces[i].key)) {
      const int p = root(faces[i].tetrahedron), q = root(faces[i - 1].tetrahedron);
      parent[std::max(p, q)] = std::min(p, q);
    }
  std::vector<int> region(parent.size(), -1);
  count = 0;
  for (std::size_t i = 0; i < parent.size(); ++i) {
    const int r = root(static_cast<int>(i));
    region[i] = r == static_cast<int>(i) ? count++ : region[r];
  }
  return region;
}

}  // namespace

void drop_cavities(Mesh& solid, const Mesh& surface) {
  std::set<Triangle> walls;
  std::set<Triangle> outward;
  for (Triangle t : surface.triangles) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    outward.insert(t);
    std::sort(t.begin(), t.end());
    walls.insert(t);
  }
  int count = 0;
  const std::vector<int> region = find_regions(solid, walls, count);
  if (count < 2) return;
  // A region is inside when its faces on the surface point as the surface does.
  std::vector<char> inside(static_cast<std::size_t>(count), 0);
  for (std::size_t i = 0; i < solid.tetrahedra.size(); ++i)
    for (const auto& f : kFaces) {
      const Tetrahedron& t = solid.tetrahedra[i];
      Triangle face{t[f[0]], t[f[1]], t[f[2]]};
      std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
      if (outward.count(face)) inside[region[i]] = 1;
    }
  std::vector<Tetrahedron> kept;
  for (std::size_t i = 0; i < solid.tetrahedra.size(); ++i)
    if (inside[region[i]]) kept.push_back(solid.tetrahedra[i]);
  solid.tetrahedra = std::move(kept);
  solid.triangles = boundary_triangles(solid.tetrahedra);
  drop_unused_nodes(solid);
}

}  // namespace kt
