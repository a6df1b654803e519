#pragma once
// Where tools touch, or will, until a local model that is made now is in use no more: what its patch has to cover.
#include <span>

#include "core/body/surface.hpp"
#include "core/local/reducer.hpp"
#include "haptics/options/touch_options.hpp"

namespace kt {

/// A tool as the patch sees it.
struct ToolPlace {
  Vec3 place = Vec3::Zero();  ///< [m]
  int triangle = -1;          ///< of the surface, in contact with it; -1: none
  double reach = 0;           ///< around it, of a model that is there at once [m]
  Vec3 way = Vec3::Zero();    ///< that it is expected to go while the model is on its way [m]
  double margin = 0;          ///< that it may be off after that [m]
};

/// How far from its place a tool may touch within `seconds` [m]: 1.2 times its own reach (of a ball above 10 mm: what
/// it touches now and 5 mm around, at least 15 mm, no more than 100 nodes), or as far as its contact, if that is known
/// and less, and at least three quarters of the tool's reach; and what it goes at half as fast again as now, and a
/// little more; never at more than kFollowedSpeed.
/// @param x               of the whole body [m], (3n)
/// @param velocity        measured [m/s]
/// @param contact_extent  from its middle, of all that the contact may become in that time [m]; 0: not known
double patch_reach(const Surface& surface, const VectorX& x, const TouchTool& tool, const Vec3& place,
                   const Vec3& velocity, double seconds, double contact_extent);

/// What a local model that comes late adds to the place of a tool: the way until it is there, and the margin.
/// @param velocity  measured [m/s]      @param way  expected in that time [m]      @param delay  that time [s]
void expect_late(const TouchTool& tool, const Vec3& velocity, const Vec3& way, double delay, ToolPlace& place);

/// The place on the surface at x that is nearest to the tool: on `triangle` when that is in contact (>= 0), or of an
/// embedded surface near it, not on the other side of a thin body.
ContactSite find_contact_site(const Surface& surface, const VectorX& x, const Vec3& tool, int triangle, double reach);

/// The sites of all tools in one, the first one's first. Left out are those that are further from the surface than
/// twice their reach: nothing that such a tool could meet is worth a larger model. One is always there. Ways and
/// margins are shortened, all parts alike, to what makes a patch half as large again as without: the apron does the
/// rest.
ContactSite find_contact_sites(const Surface& surface, const VectorX& x, std::span<const ToolPlace> tools);

}  // namespace kt
