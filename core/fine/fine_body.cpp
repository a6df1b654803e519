#include "core/fine/fine_body.hpp"

#include "core/body/embedded_surface.hpp"
#include "core/fine/isotropic_cells.hpp"

namespace kt {
namespace {

std::vector<std::array<int, 4>> find_across(std::span<const Tetrahedron> cells) {
  std::vector<std::array<int, 4>> out(cells.size(), {-1, -1, -1, -1});
  std::map<Triangle, std::pair<int, int>> open;
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int f = 0; f < 4; ++f) {
      const auto [found, is_new] = open.try_emplace(ascending(face_of(cells[c], f)), static_cast<int>(c), f);
      if (is_new) continue;
      out[c][f] = found->second.first;
      out[found->second.first][found->second.second] = static_cast<int>(c);
    }
  return out;
}

}  // namespace

FineBody make_fine_body(const DeformableModel& model, const Refinable& material) {
  FineBody out;
  out.mesh = &model.mesh();
  out.material = &material;
  out.is_fixed.assign(static_cast<std::size_t>(out.mesh->num_nodes()), 0);
  for (const int i : model.fixed_nodes()) out.is_fixed[i] = 1;
  const std::vector<Tetrahedron>& cells = out.mesh->tetrahedra;
  out.across = find_across(cells);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const std::span<const int> nodes = material.cell_nodes(static_cast<int>(c));
    if (nodes.size() < 10) continue;
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = std::minmax(cells[c][kCellEdges[e][0]], cells[c][kCellEdges[e][1]]);
      out.edge_node[{a, b}] = nodes[4 + e];
    }
  }
  if (out.mesh->embedded) {
    out.depths = std::make_unique<KnownDepths>(*out.mesh->embedded->material, out.mesh->x);
    return out;
  }
  for (std::size_t t = 0; t < out.mesh->triangles.size(); ++t)
    out.triangle[ascending(out.mesh->triangles[t])] = static_cast<int>(t);
  return out;
}

RefinableBody make_refinable_body(const DeformableModel& model, const Surface& surface) {
  RefinableBody out;
  const Refinable* material = told_by(model);
  if (!material) {
    out.isotropic = isotropic_cells(model);
    material = out.isotropic.get();
  }
  out.fine = make_fine_body(model, *material);
  if (surface.embedded) return out;
  out.fine.triangle.clear();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    out.fine.triangle[ascending(surface.triangles[t])] = static_cast<int>(t);
  return out;
}

}  // namespace kt
