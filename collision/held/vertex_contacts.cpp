#include "collision/held/vertex_contacts.hpp"

#include <algorithm>
#include <utility>

namespace kt {
namespace {

Vec3 nearest_on(const ToolCore& core, const Vec3& at) noexcept {
  const Vec3& from = core.corners[0];
  if (core.corners.size() < 2) return from;
  const Vec3 along = core.corners[1] - from;
  const double length_sq = along.squaredNorm();
  return length_sq > 0 ? Vec3(from + std::clamp((at - from).dot(along) / length_sq, 0.0, 1.0) * along) : from;
}

}  // namespace

void add_vertex_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius,
                         double margin, std::span<const int> triangles, std::vector<char>& is_seen,
                         ContactSet& out) noexcept {
  for (const int t : triangles)
    for (const int v : patch.triangles[t]) {
      if (std::exchange(is_seen[static_cast<std::size_t>(v)], 1)) continue;
      const Vec3 at = node(x, v), place = nearest_on(core, at), apart = place - at;
      const double distance = apart.norm();
      if (!(distance < radius + margin && distance > 0)) continue;
      Contact contact;
      contact.triangle = patch.topology.triangles_of(v).front();  // the same one from tick to tick
      contact.bary = Vec3::Unit(std::ranges::find(patch.triangles[contact.triangle], v) -
                                patch.triangles[contact.triangle].begin());
      contact.normal = apart / distance;
      contact.gap = distance - radius;
      contact.core = place;
      out.add(contact);
    }
  for (const int t : triangles)
    for (const int v : patch.triangles[t]) is_seen[static_cast<std::size_t>(v)] = 0;
}

}  // namespace kt
