#pragma once
// A surface that is embedded in cells, in the leaves of these.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills zone.embedded: the triangles with a vertex in reach whose vertices are all in the zone, each vertex in the
/// eighth of a leaf that holds it.
void add_embedded_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

/// How much of each leaf is material, at least a thousandth; empty: the cells are whole.
std::vector<double> leaf_shares(const FineBody& body, const FineNodes& nodes, const FineZone& zone);

}  // namespace kt
