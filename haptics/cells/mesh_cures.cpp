#include "haptics/cells/mesh_cures.hpp"

#include <algorithm>
#include <array>

#include "core/base/error.hpp"

namespace kt {

bool fills_surface(const Scene& scene) {
  const std::string& file = scene.object.mesh;
  return !scene.object.layers && std::ranges::any_of(std::array{".obj", ".off", ".ply", ".stl"},
                                                     [&](const char* end) { return file.ends_with(end); });
}

Cure finer_cells(const Scene& scene) {
  if (scene.object.body == "lattice") return advise("take finer cells (object.lattice.edge)");
  return advise(fills_surface(scene) ? "take finer cells (object.tetrahedralize.max_edge)"
                                     : "take finer cells (another object.mesh)");
}

Cure coarser_cells(const Scene& scene) {
  if (scene.object.body == "lattice") return advise("take coarser cells (object.lattice.edge)");
  return advise(fills_surface(scene) ? "take a coarser mesh (object.tetrahedralize.max_volume, or fewer triangles in "
                                       "object.mesh)"
                                     : "take a coarser mesh (another object.mesh)");
}

Cure fewer_tool_triangles(const std::string& name, std::size_t triangles) {
  return advise(
      told("take fewer triangles in ", name, ".mesh (", triangles, " now, up to ", kManyToolTriangles, " are quick)"));
}

}  // namespace kt
