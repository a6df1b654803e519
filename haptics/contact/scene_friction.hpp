#pragma once
// The scene's friction by place, resolved once: a coefficient of every surface triangle.
#include "core/local/reducer.hpp"
#include "haptics/contact/friction.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// Friction outside of all regions.
inline Friction base_friction(const ContactSettings& contact) {
  return {contact.mu_static, contact.mu_kinetic, contact.stribeck};
}

/// @param rest  node positions that the regions' boxes are meant for [m], (3n)
/// @returns a table by surface triangle, empty without regions: that of the last region whose box holds the triangle's
///          centroid at rest. A region that holds none is named in `warnings`.
SurfaceFriction scene_friction(const ContactSettings& contact, const Surface& surface, const VectorX& rest,
                               std::vector<std::string>& warnings);

}  // namespace kt
