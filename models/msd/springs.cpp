#include "models/msd/springs.hpp"

#include <algorithm>
#include <map>

#include "core/base/error.hpp"

namespace kt {
namespace {

double area(const VectorX& x, const Triangle& t) {
  const Vec3 a = node(x, t[0]);
  return 0.5 * (node(x, t[1]) - a).cross(node(x, t[2]) - a).norm();
}

}  // namespace

std::vector<Spring> make_springs(const Mesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  const auto add_edges = [&](const auto& cell) {
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t k = i + 1; k < cell.size(); ++k) edges.emplace_back(std::minmax(cell[i], cell[k]));
  };
  for (const Tetrahedron& t : mesh.tetrahedra) add_edges(t);
  for (const Triangle& t : mesh.triangles) add_edges(t);
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  std::vector<Spring> springs;
  springs.reserve(edges.size());
  for (const auto& [a, b] : edges) {
    const double length = (node(mesh.x, b) - node(mesh.x, a)).norm();
    if (!(length > 0)) throw InputError(text("msd: nodes ", a, " and ", b, " of one edge lie on the same point"));
    springs.push_back({a, b, length});
  }
  return springs;
}

void stiffen(const Mesh& mesh, const std::vector<double>& factors, std::vector<Spring>& springs) {
  if (factors.empty()) return;
  struct Around {
    double size = 0, stiff_size = 0;  // of the elements; times their factors
  };
  std::map<std::pair<int, int>, Around> around;
  const auto add = [&](const auto& cell, double size, double factor) {
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t k = i + 1; k < cell.size(); ++k) {
        Around& sum = around[std::minmax(cell[i], cell[k])];
        sum.size += size;
        sum.stiff_size += size * factor;
      }
  };
  if (mesh.tetrahedra.empty())
    for (std::size_t e = 0; e < factors.size(); ++e)
      add(mesh.triangles[e], area(mesh.x, mesh.triangles[e]), factors[e]);
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e)
    add(mesh.tetrahedra[e], std::abs(tetrahedron_volume(mesh.x, mesh.tetrahedra[e])), factors[e]);
  for (Spring& s : springs)
    if (const auto it = around.find({s.a, s.b}); it != around.end() && it->second.size > 0)
      s.stiffness *= it->second.stiff_size / it->second.size;
}

VectorX lumped_masses(const Mesh& mesh, double density, double thickness, const std::vector<double>& share) {
  VectorX mass = VectorX::Zero(mesh.num_nodes());
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const Tetrahedron& t = mesh.tetrahedra[e];
    for (int i : t) mass[i] += (share.empty() ? 1 : share[e]) * density * std::abs(tetrahedron_volume(mesh.x, t)) / 4;
  }
  if (mesh.tetrahedra.empty())
    for (const Triangle& t : mesh.triangles)
      for (int i : t) mass[i] += density * thickness * area(mesh.x, t) / 3;
  return mass;
}

Mesh add_inner_layers(const Mesh& surface, int count, double thickness) {
  if (count < 1) throw InputError(text("layers.count = ", count, ": must be >= 1"));
  if (!(thickness > 0)) throw InputError(text("layers.thickness = ", thickness, " m: must be > 0"));
  const int n = surface.num_nodes();
  const VectorX normals = node_normals(surface.x, surface.triangles);
  Mesh out;
  out.triangles = surface.triangles;
  out.x.resize(3 * n * (count + 1));
  for (int layer = 0; layer <= count; ++layer)
    out.x.segment(3 * n * layer, 3 * n) = surface.x - (thickness * layer / count) * normals;
  for (int layer = 0; layer < count; ++layer)
    for (const Triangle& t : surface.triangles) {
      // A prism below the triangle. Splitting by ascending node number makes neighbours agree on the shared diagonals.
      // All three are turned the same way: negative below an even permutation of t.
      Triangle s = t;
      std::sort(s.begin(), s.end());
      const int top = n * layer, bottom = n * (layer + 1);
      for (Tetrahedron tet : {Tetrahedron{top + s[0], top + s[1], top + s[2], bottom + s[2]},
                              Tetrahedron{top + s[0], bottom + s[1], top + s[1], bottom + s[2]},
                              Tetrahedron{top + s[0], bottom + s[0], bottom + s[1], bottom + s[2]}}) {
        const double volume = tetrahedron_volume(out.x, tet);
        // An even permutation of t keeps the orientation of the prism, an odd one mirrors it.
        const bool even =
            (s[0] == t[0] && s[1] == t[1]) || (s[0] == t[1] && s[1] == t[2]) || (s[0] == t[2] && s[1] == t[0]);
        if ((even ? -volume : volume) <= 0)
          throw InputError(text("layers.thickness = ", thickness, " m: the inner layer folds below the triangle (",
                                t[0], ", ", t[1], ", ", t[2], "); use a smaller thickness"));
        if (volume < 0) std::swap(tet[2], tet[3]);
        out.tetrahedra.push_back(tet);
      }
    }
  return out;
}

}  // namespace kt
