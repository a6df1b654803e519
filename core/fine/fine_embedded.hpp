#pragma once
// A surface that is embedded in cells, in the leaves of these.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills zone.embedded: the triangles with a vertex in reach whose vertices are all in the zone, each vertex in the
/// eighth of a leaf that holds it.
void add_embedded_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

/// Whether a leaf of a cell is empty: no material of the cell is as near as its corners are to its middle.
bool holds_nothing(const FineBody& body, int cell, const std::array<CellPoint, 4>& corners);

/// Of a leaf's stiffness, where the surface leaves no material in it.
constexpr double kLeastMaterial = 1e-3;
/// Of an empty one's: so that what is joined to nothing else stays in place.
constexpr double kEmptyMaterial = 1e-2 * kLeastMaterial;

/// Where each leaf is integrated over its material: none where it is whole. In each of its eighths that the surface
/// cuts, constant and linear functions exactly; where it holds none, all over with kLeastMaterial, or
/// kEmptyMaterial.
std::vector<std::vector<LeafPoint>> leaf_points(const FineBody& body, const FineNodes& nodes, const FineZone& zone);

}  // namespace kt
