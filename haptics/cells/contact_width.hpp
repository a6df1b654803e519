#pragma once
// The surface's cells against the width of the contact. A sphere pressed in by d touches over a circle of radius
// a = sqrt(R d) (Hertz). Where the cells are as long as that, few nodes carry the force, and it is too large. The tip
// of a capsule or a mesh tool counts as the ball that is as wide as it at that depth. An edge touches along a line:
// there a is half the width of the contact.
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "core/base/types.hpp"
#include "core/body/mesh.hpp"

namespace kt {

class BuiltScene;

/// Of the places where a tool is at least half as deep as it gets, below the body at rest.
struct ContactWidth {
  double cell = 0;            ///< side of the surface's cells under the tool, sqrt(2 area of a triangle), mean [m]
  double contact_radius = 0;  ///< mean [m]
  double least = 0, mean = 0, most = 0;                        ///< cell / contact radius [-]
  bool is_line = false;                                        ///< everywhere, as under a capsule that lies
  bool is_refined = false;                                     ///< under the tool, by local.refine
  std::string why_not{};                                       ///< else the reason
  double fineness = std::numeric_limits<double>::quiet_NaN();  ///< refined cell / contact radius; NaN: not measured
  /// Of the continuum's force to expect, mean; where cells are refined, after that. NaN: not known of this tool or
  /// model, nor of a line on cells as they are.
  double factor = std::numeric_limits<double>::quiet_NaN();
  double fine_edge = std::numeric_limits<double>::quiet_NaN();  ///< of the surface, for a factor of kCoarseForce [m]
};

/// Whether the factor is worth a warning.
bool is_off(const ContactWidth& width);

/// Along the way of the scene's first tool; none when the tool has no radius or nowhere enters the body at rest. At
/// most some hundred places are looked at.
/// @param fineness  of the refined cells in the run; NaN: that of local.fineness is expected
std::optional<ContactWidth> find_contact_width(const BuiltScene& built, std::span<const Pose> way,
                                               double fineness = std::numeric_limits<double>::quiet_NaN());
/// Along places of a tool that keeps the orientation that it has at the start.
std::optional<ContactWidth> find_contact_width(const BuiltScene& built, std::span<const Vec3> places);

/// The same contact on cells `coarser` times as long, or with another element: whether its factor is worth a warning.
bool stays_fine(const BuiltScene& built, const ContactWidth& width, double coarser, const std::string& element);

/// For a factor that is off: cell, contact radius, factor, and the settings that cure it, each with its price.
/// @param refresh_share  time of a refresh over the time that there is for one; 0: not known
Finding coarse_mesh_finding(const BuiltScene& built, const ContactWidth& width, double refresh_share = 0);

}  // namespace kt
