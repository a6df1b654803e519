#pragma once
// The surface of leaves.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// Fills the zone's facets: four flat ones for each leaf's face on the body's surface, where one of the four's nodes is
/// in reach.
void add_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone);

}  // namespace kt
