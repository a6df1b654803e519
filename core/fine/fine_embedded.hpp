#pragma once
// A surface that is embedded in cells, in the leaves of these.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills zone.embedded: the triangles with a vertex in reach whose vertices are all in the zone, each vertex in the
/// eighth of a leaf that holds it.
void add_embedded_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

/// Weights of each leaf's points, so that constant and linear functions are integrated over its material: their sum is
/// how much of it is, a thousandth at least. Empty: the cells are whole.
std::vector<Eigen::Vector4d> leaf_weights(const FineBody& body, const FineNodes& nodes, const FineZone& zone);

}  // namespace kt
