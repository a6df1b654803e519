#pragma once
// A tool as a refresh sees it: where it touches, how wide, and where it goes.
#include <optional>
#include <span>
#include <vector>

#include "collision/shape/tool_shape.hpp"
#include "core/body/state.hpp"
#include "haptics/refresh/contact_nodes.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// A tool as the patch and the refined cells see it.
struct SeenTool {
  std::vector<Vec3> core;        ///< some points of it, a radius within its surface [m]
  Vec3 velocity = Vec3::Zero();  ///< [m/s]; along the surface that of the body under it less
  double time = 0;               ///< until the next local model is there [s]
  double acceleration = 0;       ///< that it may have while it comes near and models are late [m/s^2]
  /// Longest time of late between refreshes over the usual interval, 1 to 3, forgotten by a tenth at each refresh; from
  /// the schedule alone.
  double late = 1;
  double contact_radius = 0;  ///< measured [m]; 0: not known
  /// Of the contact of a capsule that lies: from its middle to its end, on the body at rest, and half its width [m];
  /// zero: it is about round, or not known.
  Vec3 half_length = Vec3::Zero();
  double half_width = 0;
  int triangle = -1;           ///< of the surface, that it touches: of some that nearest to its reference point
  Vec3 normal = Vec3::Zero();  ///< of its contacts by force, from the body towards it, unit; zero: it touches nothing
  std::optional<Vec3>
      touched{};  ///< middle of its contacts by force, on the body at rest [m]; none: it touches nothing
};

/// What a tool touches. Borrowed.
struct TouchedBody {
  const Surface& surface;
  const ContactNodes& nodes;
  const VectorX& rest;  ///< positions [m]
  const VectorX& v;     ///< velocities now [m/s]
};

/// Radius of a contact that the tool presses deeper by `way` [m]; of a ball no more than its own: the cells and places
/// of a wider one are so far apart that the ball lies between them. A capsule's contact may be as long as the capsule.
double pressed_radius(const ToolShape& shape, double radius, double way);

/// How far the contact of a ball or a capsule reaches from its middle until the model after the next is there [m]; 0:
/// not known, or of another tool. Of a ball that is pressed in by d sqrt(2 R d). A capsule's contact moves along it,
/// and where models come late a patch has to do for longer.
double contact_extent(const ToolShape& shape, const SeenTool& seen, bool models_come_late);

/// From the last reports, oldest first; without any of the shape alone. `time` and `late` are left as they are.
SeenTool see_tool(const TouchedBody& body, const ToolShape& shape, const Pose& at, std::span<const LocalReport> reports,
                  int tool, double rate_hz);

}  // namespace kt
