#pragma once
// The surface of a zone: of leaves' faces (fine_facets.cpp), or a scan's, embedded in leaves (fine_embedded.cpp), and
// where on that tools are held (places_apart.cpp). Some of a scan's vertices, which may be far more than the leaves
// have nodes: the contacts' matrix is singular then, and a tick has no room for all. Which ones it left out changed
// from tick to tick, and the force with them.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills the zone's facets: four flat ones for each leaf's face on the body's surface, where one of the four's nodes is
/// in reach.
void add_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

/// Fills zone.embedded: the triangles with a vertex in reach whose vertices are all in the zone, in pieces with edges
/// of twice options.apart at most, each vertex in the eighth of a leaf that holds it.
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

/// Chooses the places of zone.embedded, apart as it says or, where there would be more of them than yielding nodes,
/// further, with as many between them as there is room for, and how the other vertices yield with them. None where
/// nothing yields.
/// @param x  of the body at rest [m]
void choose_places(const VectorX& x, FineZone& zone);

}  // namespace kt
