#pragma once
// What to change for other cells: by what the scene's body was made from.
#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// The body's surface is split and filled as object.tetrahedralize says; else its file or object.layers has the
/// tetrahedra.
bool fills_surface(const Scene& scene);
Cure finer_cells(const Scene& scene);
Cure coarser_cells(const Scene& scene);

/// Of a mesh tool: from here on its triangles are what takes long.
constexpr std::size_t kManyToolTriangles = 2000;
/// @param name  of the tool in the scene
Cure fewer_tool_triangles(const std::string& name, std::size_t triangles);

}  // namespace kt
