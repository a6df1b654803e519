#pragma once
// The contacts of a tool by all pairs: each triangle of the surface with each corner, edge and triangle of the core.
#include "collision/held/tool_contacts.hpp"

namespace kt {

/// With a gap below `margin` [m], in no order, the same place as often as triangles and features share it.
std::vector<Contact> contacts_by_triangles(const SurfacePatch& patch, const VectorX& x, const ToolCore& core,
                                           double radius, double margin);

}  // namespace kt
