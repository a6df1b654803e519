#include "haptics/self_contact_check.hpp"

#include <numeric>

#include "core/error.hpp"
#include "io/mesh_doctor.hpp"

namespace kt {
namespace {

std::string place(const Vec3& at) { return text("(", at.x(), ", ", at.y(), ", ", at.z(), ") m"); }

/// For each node the lowest one of its piece.
std::vector<int> pieces(const Mesh& mesh) {
  std::vector<int> parent(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto join = [&](const auto& nodes) {
    for (int i : nodes) parent[std::max(root(i), root(nodes[0]))] = std::min(root(i), root(nodes[0]));
  };
  for (const Triangle& t : mesh.triangles) join(t);
  for (const Tetrahedron& t : mesh.tetrahedra) join(t);
  for (int i = 0; i < mesh.num_nodes(); ++i) parent[i] = root(i);
  return parent;
}

void require_apart(const Mesh& mesh) {
#if KT_WITH_CGAL
  bool complete = false;
  const auto pairs = find_self_intersections(mesh, 1, complete);
  if (pairs.empty()) return;
  const Triangle& t = mesh.triangles[pairs[0][0]];
  const Vec3 at = (node(mesh.x, t[0]) + node(mesh.x, t[1]) + node(mesh.x, t[2])) / 3;
  throw InputError(text("object.self_contact: the surface passes through itself at the start, at triangles ",
                        pairs[0][0], " and ", pairs[0][1], " near ", place(at),
                        ": repair the mesh (kilotouch mesh repair) or move the pieces apart"));
#else
  (void)mesh;
#endif
}

}  // namespace

void check_self_contact(const Mesh& mesh, const std::vector<int>& fixed_nodes) {
  require_apart(mesh);
  const std::vector<int> piece = pieces(mesh);
  std::vector<char> is_held(piece.size(), 0);
  for (int i : fixed_nodes) is_held[piece[i]] = 1;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (piece[i] == i && !is_held[i])
      throw InputError(text("object.self_contact: the piece of the body around ", place(node(mesh.x, i)),
                            " is not clamped: between refreshes nothing would hold it; add its nodes to object.fixed"));
}

}  // namespace kt
