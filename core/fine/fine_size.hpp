#pragma once
// How fine a patch has to be for a contact, and what its force is then worth.
#include <limits>

#include "core/fine/fine_zone.hpp"

namespace kt {

/// Mean size of the cells that hold a place of the body at rest, or are nearest to it [m]: edge of the cube that six of
/// them fill.
double cell_size_at(const FineBody& body, const Vec3& place);

/// Where a tool touches: one of a radius R pressed in by d has a contact radius of sqrt(R d).
struct FineContact {
  Vec3 centre = Vec3::Zero();  ///< of the body at rest [m]
  double contact_radius = 0;   ///< [m]
  double travel = 0;           ///< how far the tool may go before the zone is made anew [m]
  std::vector<Vec3> others{};  ///< where it or another one touches, too
  /// Of the smallest of the tools [m]: it must not pass between places of an embedded surface.
  double tool_radius = std::numeric_limits<double>::infinity();
};

/// Leaves of `fineness` contact radii in all of the contact's way, and growing outwards by their distance from it;
/// cells within 1.6 cell sizes of the centre, and half a cell beyond the way, so that what is held is far enough.
FineZoneOptions fine_options(const FineBody& body, const FineContact& contact, double fineness);

/// A radius of the zone beyond which the cells outside hardly stiffen the contact [m]: 2.6 cell sizes, and no more than
/// 4.5 contact radii. A ball 3 mm deep in the organ of scenes/organ_drag.json has 1.07 of the force of fine cells with
/// it, 1.11 with the radius of fine_options() (bench/fine_drag_table).
double wide_radius(const FineBody& body, const FineContact& contact);

/// Of the contact's radius, that a zone serves for at least.
constexpr double kLeastTravel = 0.4;

/// Places along the way of a contact's middle, at most; of a long contact along all its ways.
constexpr int kPlacesOfWay = 12, kPlacesOfTool = 24;

/// Cells that may be half as large as that give as many places to touch as a tick holds (kMaxContacts).
constexpr double kLeastFineness = 1.35;

}  // namespace kt
