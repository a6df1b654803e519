#include "haptics/contact/scene_friction.hpp"

#include "core/base/error.hpp"

namespace kt {

SurfaceFriction scene_friction(const ContactSettings& contact, const Surface& surface, const VectorX& rest,
                               std::vector<std::string>& warnings) {
  SurfaceFriction out{base_friction(contact), {}};
  if (contact.regions.empty()) return out;
  out.of_triangle.assign(surface.triangles.size(), out.everywhere);
  for (std::size_t r = 0; r < contact.regions.size(); ++r) {
    const RegionSettings& region = contact.regions[r];
    int found = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      Vec3 centroid = Vec3::Zero();
      for (int i : surface.triangles[t]) centroid += node(rest, i) / 3;
      if (((centroid - region.box[0]).array() < 0).any() || ((region.box[1] - centroid).array() < 0).any()) continue;
      out.of_triangle[t] = {region.mu_static, region.mu_kinetic, contact.stribeck};
      ++found;
    }
    if (found == 0) warnings.push_back(text("contact.regions[", r, "]: no surface triangle has its middle in the box"));
  }
  return out;
}

}  // namespace kt
