#pragma once
// How stiff the body is where the tool will press it, from its tangent at rest: for predictions before a run.
#include <optional>

namespace kt {

class BuiltScene;

struct ContactStiffness {
  double stiffness = 0;  ///< of the contact along the surface's normal [N/m]
  double damping = 0;    ///< that goes with it [N s/m]
};

/// At the deepest place of the scene's tool path, for a tool that is pressed `depth` [m] in: one solution with the
/// tangent for a unit force on the triangle there; of a ball, Hertz' 2 E* sqrt(R depth) when that is more. None when
/// the body at rest is not held (nothing clamped).
std::optional<ContactStiffness> contact_stiffness(const BuiltScene& built);

}  // namespace kt
