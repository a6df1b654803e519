#pragma once
// The cells of the formats that mix them (Gmsh, VTK, Medit) to the triangles and tetrahedra of a mesh.
#include <span>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/polygon.hpp"

namespace kt {

enum class CellKind {
  skipped,  ///< points and lines
  polygon,  ///< triangles and quadrangles among them
  strip,    ///< of triangles
  pixel,    ///< a quadrangle whose last two corners are the other way round
  tetrahedron,
};

/// What VTK's cell types are, for both of its formats.
struct VtkCellType {
  int type;
  CellKind kind;
  int corners, nodes;  ///< 0: any number
};
const VtkCellType* find_vtk_cell_type(long long type);
inline constexpr const char* kVtkCellTypes =
    "points and lines (1 to 4, 21), triangles and polygons (5 to 9, 22, 23), tetrahedra (10, 24)";

class CellCollector {
 public:
  void add(CellKind kind, std::span<const int> corners);
  /// Of a cell with nodes on its edges, of which only the corners are used.
  void add_quadratic(CellKind kind, std::span<const int> corners);

  /// A cell of VTK's formats; returns how many corners it must have, in words, when it has a wrong number, else "".
  std::string add_vtk(const VtkCellType& type, std::span<const int> corners);

  /// The mesh with nodes x: the boundary of the tetrahedra if there are any (finish_solid), else the polygons as
  /// triangles.
  /// @param drop_unused  nodes that no triangle of a surface uses
  Mesh finish(VectorX x, bool drop_unused, const std::string& path, const LoadOptions& options, Notes& notes);

 private:
  std::vector<int> corners_;           ///< of polygons
  std::vector<std::size_t> first_{0};  ///< polygon i has the corners first_[i] .. first_[i + 1]
  std::vector<Tetrahedron> tetrahedra_;
  int skipped_ = 0, quadratic_ = 0;
};

}  // namespace kt
