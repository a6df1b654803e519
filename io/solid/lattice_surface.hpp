#pragma once
// A surface made ready to be embedded.
#include <optional>

#include "io/solid/lattice.hpp"
#include "io/surface/winding_number.hpp"

namespace kt {

/// Equal coordinates joined; unused vertices and triangles without area left out. Counts these and open edges.
Mesh clean_surface(const Mesh& surface, LatticeReport& report);

/// The same shape with edges of at most that length [m]: longer ones are halved, on both sides alike.
Mesh with_short_edges(Mesh surface, double longest);

/// The same with connected pieces turned whose triangles have the material on their outside: judged at some of each
/// piece's triangles. Counts these; none: they are right as they are.
/// @param winding  of the surface
std::optional<Mesh> turn_outward(const Mesh& surface, const WindingNumber& winding, LatticeReport& report);

}  // namespace kt
