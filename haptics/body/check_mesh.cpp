#include "haptics/body/check_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"

namespace kt {
namespace {

template <class Rows>
void check_indices(const Rows& rows, const char* what, const Mesh& mesh, const std::string& name) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const int v : rows[i])
      if (v < 0 || v >= mesh.num_nodes())
        throw InputError(text(name, ": ", what, " ", i, ": node ", v, " is outside 0 .. ", mesh.num_nodes(), " - 1"));
}

void check_numbers(const Mesh& mesh, const std::string& name) {
  if (mesh.x.size() % 3 != 0) throw InputError(text(name, ": ", mesh.x.size(), " coordinates; must be three a node"));
  for (Eigen::Index i = 0; i < mesh.x.size(); ++i)
    if (!std::isfinite(mesh.x[i])) throw InputError(text(name, ": node ", i / 3, ": ", mesh.x[i], " is not finite"));
  if (mesh.triangles.empty() && mesh.tetrahedra.empty())
    throw InputError(text(name, ": has no triangles and no tetrahedra; it needs one at least"));
  check_indices(mesh.triangles, "triangle", mesh, name);
  check_indices(mesh.tetrahedra, "tetrahedron", mesh, name);
}

/// How many tetrahedra were turned.
int orient_tetrahedra(Mesh& mesh, const std::string& name) {
  int turned = 0;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    Tetrahedron& t = mesh.tetrahedra[i];
    const bool is_turned = tetrahedron_volume(mesh.x, t) < 0;
    if (is_turned) std::swap(t[2], t[3]);
    turned += is_turned;
    if (tetrahedron_volume(mesh.x, t) > 0) continue;
    const Vec3 p = node(mesh.x, t[0]);
    throw InputError(text(name, ": tetrahedron ", i, " (counted from 0) has no volume, at (", p[0], ", ", p[1], ", ",
                          p[2], ") m; leave it out, or move its nodes"));
  }
  return turned;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// Both have the same nodes.
bool are_alike(const Triangle& a, const Triangle& b) {
  const auto at = std::ranges::find(b, a[0]) - b.begin();
  return b[static_cast<std::size_t>(at + 1) % 3] == a[1];
}

/// How many triangles of the tetrahedra's boundary were turned.
int orient_triangles(Mesh& mesh) {
  std::vector<std::pair<Triangle, Triangle>> boundary;
  for (const Triangle& t : boundary_triangles(mesh.tetrahedra)) boundary.emplace_back(sorted(t), t);
  std::ranges::sort(boundary);
  int turned = 0;
  for (Triangle& t : mesh.triangles) {
    const Triangle key = sorted(t);
    const auto found = std::ranges::lower_bound(boundary, key, {}, &std::pair<Triangle, Triangle>::first);
    if (found == boundary.end() || found->first != key || are_alike(t, found->second)) continue;
    std::swap(t[1], t[2]);
    ++turned;
  }
  return turned;
}

}  // namespace

void check_and_orient(Mesh& mesh, const std::string& name, std::vector<std::string>* notes) {
  check_numbers(mesh, name);
  if (mesh.tetrahedra.empty()) return;
  const int tetrahedra = orient_tetrahedra(mesh, name);
  if (mesh.triangles.empty()) mesh.triangles = boundary_triangles(mesh.tetrahedra);
  const int triangles = orient_triangles(mesh);
  if (!notes) return;
  if (tetrahedra > 0)
    notes->push_back(text(tetrahedra, " of ", mesh.tetrahedra.size(), " tetrahedra turned to positive volume"));
  if (triangles > 0)
    notes->push_back(text(triangles, " of ", mesh.triangles.size(), " triangles turned to face outward"));
}

}  // namespace kt
