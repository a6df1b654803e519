#pragma once
// A few hundred triangles that show a mesh as a small picture does.
#include <nlohmann/json.hpp>

#include "core/body/mesh.hpp"

namespace kt {

/// Nodes merged in the cells of a grid: {"min", "size" (of the longest side), "x": three whole numbers 0 .. 255 a node
/// along each axis in parts of that side, "t": node numbers of the triangles}. Empty for a mesh without extent.
nlohmann::ordered_json outline(const Mesh& mesh);

}  // namespace kt
