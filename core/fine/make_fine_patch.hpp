#pragma once
// A zone and how it yields as a tick uses them.
#include <memory>

#include "core/fine/fine_yield.hpp"
#include "core/local/fine_patch.hpp"

namespace kt {

/// @param triangles  of the body's surface, numbered as in body.triangle
/// @param yield      of the zone's yielding nodes
std::shared_ptr<FinePatch> make_fine_patch(const FineBody& body, const FineZone& zone,
                                           std::span<const Triangle> triangles, FineYield yield);

}  // namespace kt
