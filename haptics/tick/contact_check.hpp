#pragma once
// An independent look at the end of a tick: is the tool inside the body? Brute force over the whole patch, outside the
// haptic tick's time and with none of its shortcuts.
#include "collision/shape/contact.hpp"
#include "core/local/local_model.hpp"

namespace kt {

/// Distance of a point or a sphere from the nearest of all triangles at positions x (3p) [m]; negative inside the body.
double clear_distance(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& centre);

/// Depth of the tool's deepest point below the patch at positions x (3p) [m]; 0 when it is outside.
double penetration_depth(const SurfacePatch& patch, const VectorX& x, const ToolShape& tool, const Vec3& place,
                         const Quaternion& turn = Quaternion::Identity());

}  // namespace kt
