#pragma once
// Where tools are held on a scan: some of its vertices, that lie apart. There may be far more of them than the leaves
// have nodes: the contacts' matrix is singular then, and a tick has no room for all. Which ones it left out changed
// from tick to tick, and the force with them.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Of each vertex, whether it is one of a set that no other vertex can be added to: no two are nearer than `apart` on
/// the same side of the surface. Which of two neighbours is taken depends on their numbers alone, so that most stay
/// from zone to zone, and the scan's own vertices come before those that pieces of its triangles have. (A maximal
/// independent set by fixed priorities: Luby 1986.)
/// @param x  of the body at rest [m]      @param apart  [m]
std::vector<char> places_apart(const VectorX& x, const EmbeddedFacets& facets, double apart);

}  // namespace kt
