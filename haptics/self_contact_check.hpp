#pragma once
// Whether a body can be kept from passing through itself.
#include <vector>

#include "core/mesh.hpp"

namespace kt {

/// Throws InputError when the surface intersects itself at the start (found where CGAL is built in), or when a piece of
/// the body has no fixed node: the haptic side's linear model, which knows no contact between pieces, would let it
/// fall.
void check_self_contact(const Mesh& mesh, const std::vector<int>& fixed_nodes);

}  // namespace kt
