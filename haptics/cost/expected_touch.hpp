#pragma once
// What a tick in contact will have to hold: before a tool touches from tools, path and surface, then from the ticks
// until now.
#include <span>

#include "core/local/reducer.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

struct ExpectedTouch {
  double places = 0;          ///< where tools touch at once; 0: none does
  double facets = 0;          ///< triangles around the patch that a tick looks at, too
  bool is_refined = false;    ///< the places are nodes of refined cells
  bool is_long = false;       ///< a tool is a capsule
  bool is_projected = false;  ///< one place, whose impulse is found at once: the paper's laws
  bool operator==(const ExpectedTouch&) const = default;
};

/// Of a contact that is not measured yet [m]: that of a ball pressed in by a sixteenth of its radius.
double expected_contact_radius(const ToolShape& shape);

/// Radius of the contact of a tool that is pressed in by `depth` [m]; 0: not known. No larger than the tool's.
double pressed_contact_radius(const ToolShape& shape, double depth);

/// Where a tool touches cells as they are: one place, and one more for nearly each two triangles under the contact.
/// @param triangle  mean area of the surface's triangles [m^2]
double expected_places(double contact_radius, double triangle);

/// A triangle of the surface, and the cell whose face it is.
struct SurfaceCell {
  double area = 0;  ///< of the triangle [m^2]
  double size = 0;  ///< of the cell, leaf_size() [m]
};

/// Nodes of refined cells under a contact. A cell is halved until it is no larger than `leaf`; on the surface each half
/// has two nodes for a triangle of its own.
double expected_nodes(double contact_radius, std::span<const SurfaceCell> cells, double leaf);

/// @param mesh     of the body at rest     @param patch, site  where tools are about to touch
/// @param kind     is_refined and is_projected alone
ExpectedTouch expect_touch(const TouchOptions& options, const Mesh& mesh, const Surface& surface,
                           const SurfacePatch& patch, const ContactSite& site, const ExpectedTouch& kind);

/// What was expected, with the places that ticks held since, if they touched.
ExpectedTouch seen_touch(ExpectedTouch expected, std::span<const LocalReport> reports, bool is_refined);

}  // namespace kt
