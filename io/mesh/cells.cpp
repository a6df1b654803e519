#include "io/mesh/cells.hpp"

#include "core/base/error.hpp"

namespace kt {

void CellCollector::add(CellKind kind, std::span<const int> corners) {
  const auto polygon = [&](std::span<const int> p) {
    corners_.insert(corners_.end(), p.begin(), p.end());
    first_.push_back(corners_.size());
  };
  switch (kind) {
    case CellKind::skipped:
      ++skipped_;
      return;
    case CellKind::polygon:
      return polygon(corners);
    case CellKind::pixel:
      return polygon(std::array{corners[0], corners[1], corners[3], corners[2]});
    case CellKind::strip:
      for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        const std::size_t odd = i % 2;
        polygon(std::array{corners[i], corners[i + 1 + odd], corners[i + 2 - odd]});
      }
      return;
    case CellKind::tetrahedron:
      tetrahedra_.push_back({corners[0], corners[1], corners[2], corners[3]});
      return;
  }
}

void CellCollector::add_quadratic(CellKind kind, std::span<const int> corners) {
  quadratic_ += kind != CellKind::skipped;
  add(kind, corners);
}

std::string CellCollector::add_vtk(const VtkCellType& type, std::span<const int> corners) {
  const auto nodes = static_cast<std::size_t>(type.nodes);
  if (nodes > 0 && corners.size() != nodes) return text(nodes);
  const bool has_area = type.kind == CellKind::polygon || type.kind == CellKind::strip;
  if (has_area && corners.size() < 3) return "at least 3";
  if (type.nodes > type.corners)
    add_quadratic(type.kind, corners.first(static_cast<std::size_t>(type.corners)));
  else
    add(type.kind, corners);
  return "";
}

Mesh CellCollector::finish(VectorX x, bool drop_unused, const std::string& path, const LoadOptions& options,
                           Notes& notes) {
  Mesh mesh;
  mesh.x = std::move(x);
  mesh.tetrahedra = std::move(tetrahedra_);
  if (skipped_ > 0) notes.push_back(text(skipped_, " point and line elements skipped"));
  if (quadratic_ > 0) notes.push_back(text(quadratic_, " quadratic elements: the mid-edge nodes are not used"));
  if (!mesh.tetrahedra.empty()) {
    finish_solid(mesh, path, options, notes);
    return mesh;
  }
  PolygonTriangulator triangulator;
  for (std::size_t i = 0; i + 1 < first_.size(); ++i)
    triangulator.add(mesh.x, std::span(corners_).subspan(first_[i], first_[i + 1] - first_[i]), mesh.triangles);
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
  if (options.lenient || !drop_unused) return mesh;
  if (const int dropped = drop_unused_nodes(mesh); dropped > 0)
    notes.push_back(text(dropped, " nodes that no triangle uses dropped"));
  return mesh;
}

const VtkCellType* find_vtk_cell_type(long long type) {
  using enum CellKind;
  static constexpr VtkCellType kTypes[] = {
      {1, skipped, 1, 1},  {2, skipped, 0, 0},  {3, skipped, 2, 2},  {4, skipped, 0, 0},      {5, polygon, 3, 3},
      {6, strip, 0, 0},    {7, polygon, 0, 0},  {8, pixel, 4, 4},    {9, polygon, 4, 4},      {10, tetrahedron, 4, 4},
      {21, skipped, 2, 3}, {22, polygon, 3, 6}, {23, polygon, 4, 8}, {24, tetrahedron, 4, 10}};
  for (const VtkCellType& t : kTypes)
    if (t.type == type) return &t;
  return nullptr;
}

}  // namespace kt
