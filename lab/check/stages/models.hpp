#pragma once
// What of a body is clamped before it is touched.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Of each piece the lowest fifth along z, of a sheet that lies flat one end; more where that leaves the piece free to
/// turn. Ascending.
std::vector<int> held_nodes(const Mesh& body, bool is_sheet);

}  // namespace kt
