#pragma once
#include "core/body/mesh.hpp"

namespace kt {

/// kuhn_block(n, n, n, h), n >= 3, with one inner node moved until the flattest tetrahedron has this smallest dihedral
/// angle [degrees], at most 45 (none is moved then).
Mesh block_with_sliver(int n, double h, double dihedral_deg);

}  // namespace kt
