#pragma once
#include "core/body/mesh.hpp"

namespace kt {

/// How good the tetrahedra of a solid are for simulation.
struct TetrahedraQuality {
  double volume = 0;           ///< of all [m^3]
  double volume_min = 0;       ///< smallest [m^3]
  double radius_edge_max = 0;  ///< largest circumradius / shortest edge [-]; a regular tetrahedron has 0.61
  double dihedral_min = 0;     ///< smallest angle between two faces [degrees]; a regular tetrahedron has 70.5
};

/// All zero for a mesh without tetrahedra.
TetrahedraQuality tetrahedra_quality(const Mesh& solid);

}  // namespace kt
