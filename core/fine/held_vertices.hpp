#pragma once
// At which vertices of an embedded surface a tool is held.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Vertices as far apart as the nodes of the leaves that hold them, those at sharp edges first. A leaf takes on the
/// tool's shape where its nodes do: held at the many vertices of a scan in it, it would be bent as it cannot be, and
/// the force be up to a third too large (docs/lattice.md). A maximal independent set by priorities (Luby 1986) that a
/// vertex keeps from zone to zone.
/// @return  of surface.vertex: distance to the nearest one that a tool is held at [m]; 0: it is one
std::vector<double> distance_to_held(const FineBody& body, const EmbeddedFacets& surface);

}  // namespace kt
