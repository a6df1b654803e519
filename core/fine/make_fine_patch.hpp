#pragma once
// A zone and how it yields as a tick uses them.
#include <memory>

#include "core/fine/fine_yield.hpp"
#include "core/local/fine_patch.hpp"

namespace kt {

/// All that a patch depends on besides the body at rest and its material: a computer that has these makes the same one.
struct FineOrigin {
  FineZoneOptions options;  ///< with the edge that was taken
  TangentKind kind = TangentKind::symmetric;
  double fineness = 0;
  VectorX x, v;  ///< of the zone's nodes, in the order of zone_nodes() [m], [m/s]
};
/// Nodes of the body that the zone's cells have, ascending.
std::vector<int> zone_nodes(const FineBody& body, const FineZone& zone);
FineOrigin fine_origin(const FineBody& body, const FineZone& zone, FineZoneOptions options, const FineState& state);

/// @param triangles  of the body's surface, numbered as in body.triangle
/// @param yield      of the zone's points
std::shared_ptr<FinePatch> make_fine_patch(const FineBody& body, const FineZone& zone,
                                           std::span<const Triangle> triangles, FineYield yield);

}  // namespace kt
