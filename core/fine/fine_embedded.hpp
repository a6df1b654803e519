#pragma once
// A surface that is embedded in cells, in the leaves of these.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills zone.embedded: the triangles with a vertex in reach whose vertices are all in the zone, each vertex in the
/// eighth of a leaf that holds it.
void add_embedded_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

/// Where each leaf is integrated over its material: none where it is whole. In each of its eighths that the surface
/// cuts, constant and linear functions exactly; where it holds none, all over with a thousandth.
std::vector<std::vector<LeafPoint>> leaf_points(const FineBody& body, const FineNodes& nodes, const FineZone& zone);

}  // namespace kt
