#include "tests/support/dense_tool_contacts.hpp"

#include "collision/shape/closest_point.hpp"

namespace kt {

std::vector<Contact> contacts_by_triangles(const SurfacePatch& patch, const VectorX& x, const ToolCore& core,
                                           double radius, double margin) {
  std::vector<Contact> out;
  for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t) {
    const Triangle& v = patch.triangles[t];
    const auto add = [&](const Vec3& place) {
      if (const auto contact = find_sphere_contact(patch, x, place, radius, margin, t)) out.push_back(*contact);
    };
    for (const Vec3& corner : core.corners) add(corner);
    for (const auto& [i, k] : core.edges)
      for (int c = 0; c < 3; ++c) {
        const Vec3 &a = core.corners[i], &b = core.corners[k];
        const auto [s, u] = closest_parameters(a, b, node(x, v[c]), node(x, v[(c + 1) % 3]));
        if (s > 0 && s < 1) add((1 - s) * a + s * b);
      }
    for (const Triangle& face : core.triangles)
      for (const int vertex : v) {
        const ClosestPoint at = closest_point_on_triangle(node(x, vertex), core.corners[face[0]], core.corners[face[1]],
                                                          core.corners[face[2]]);
        if (at.feature == ClosestPoint::Feature::face) add(at.point);
      }
  }
  return out;
}

}  // namespace kt
