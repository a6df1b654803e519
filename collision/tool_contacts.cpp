#include "collision/tool_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "collision/closest_point.hpp"
#include "collision/pair_distance.hpp"

namespace kt {
namespace {

Box box_of(const VectorX& x, const Triangle& t, double margin) noexcept {
  const Vec3 a = node(x, t[0]), b = node(x, t[1]), c = node(x, t[2]);
  return {a.cwiseMin(b).cwiseMin(c).array() - margin, a.cwiseMax(b).cwiseMax(c).array() + margin};
}

bool holds(const Box& box, const Vec3& p) noexcept {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

bool is_apart(const Box& box, const Vec3& a, const Vec3& b) noexcept {
  return kt::is_apart(box, Box{a.cwiseMin(b), a.cwiseMax(b)});
}

/// Contacts of one direction within a part of a triangle push the same nodes the same way: the deepest stands for all.
struct Apart {
  double spacing;  // of a triangle's first edge
  double along;    // cosine between normals
};
constexpr Apart kFlat{0.02, 0.9999};
/// The pieces of a smooth surface are much smaller than what its nodes move, and turn little from one to the next.
/// A capsule of 20 mm on pieces of 1.25 mm: a third of the time with kFlat, and no contact is left over that the solver
/// has no room for.
constexpr Apart kCurved{0.5, 0.999};

void add_apart(ContactSet& set, const Contact& contact, double spacing_sq, double along) noexcept {
  for (int i = 0; i < set.count; ++i) {
    Contact& other = set.contacts[i];
    if ((other.core - contact.core).squaredNorm() > spacing_sq || other.normal.dot(contact.normal) < along) continue;
    if (contact.gap < other.gap) other = contact;
    return;
  }
  set.add(contact);
}

}  // namespace

void find_tool_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
                        std::span<const int> candidates, int start, ContactSet& out, const Vec3& way,
                        double overlap) noexcept {
  if (core.edges.empty())
    return find_sphere_contacts(patch, x, core.corners[0], radius, margin, candidates, start, out, way, overlap);
  out.count = 0;
  const Apart apart = patch.is_curved ? kCurved : kFlat;
  const double limit = radius + margin;
  const auto add = [&](const Vec3& place, int triangle) {
    const Triangle& v = patch.triangles[triangle];
    if (const auto contact = find_sphere_contact(patch, x, place, radius, margin, triangle))
      add_apart(out, *contact, apart.spacing * apart.spacing * (node(x, v[1]) - node(x, v[0])).squaredNorm(),
                apart.along);
  };

  Box near{Vec3::Constant(std::numeric_limits<double>::infinity()), {}};
  near.high = -near.low;
  for (const int t : candidates) {
    const Box box = box_of(x, patch.triangles[t], limit);
    near.low = near.low.cwiseMin(box.low);
    near.high = near.high.cwiseMax(box.high);
  }
  for (const Vec3& corner : core.corners) {
    const bool is_deep = start >= 0 && overlap > 0;
    if (!is_deep && !holds(near, corner)) continue;
    const int before = out.count;
    for (const int t : candidates)
      if (holds(box_of(x, patch.triangles[t], limit), corner)) add(corner, t);
    // Nothing in front of the corner: it may have gone through the surface near where the tool touched before.
    if (out.count > before || start < 0) continue;
    Contact inside = track_point_contact(patch, x, corner, start);
    constexpr double kOn = 1e-9;  // of the radius, as in find_sphere_contacts()
    if (!(inside.gap <= kOn * radius && inside.gap > -2 * limit - way.norm() - overlap)) continue;
    inside.gap -= radius;
    inside.core = corner;
    out.add(inside);
  }
  for (const auto& [i, k] : core.edges) {
    const Vec3 &a = core.corners[i], &b = core.corners[k];
    if (is_apart(near, a, b)) continue;
    for (const int t : candidates) {
      const Triangle& v = patch.triangles[t];
      if (is_apart(box_of(x, v, limit), a, b)) continue;
      for (int c = 0; c < 3; ++c) {
        const auto [s, u] = closest_parameters(a, b, node(x, v[c]), node(x, v[(c + 1) % 3]));
        if (s > 0 && s < 1) add((1 - s) * a + s * b, t);
      }
    }
  }
  for (const Triangle& face : core.triangles) {
    const Vec3 &a = core.corners[face[0]], &b = core.corners[face[1]], &c = core.corners[face[2]];
    const Box box{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    if (kt::is_apart(near, box)) continue;
    for (const int t : candidates) {
      if (kt::is_apart(box_of(x, patch.triangles[t], limit), box)) continue;
      for (const int vertex : patch.triangles[t]) {
        const ClosestPoint at = closest_point_on_triangle(node(x, vertex), a, b, c);
        if (at.feature == ClosestPoint::Feature::face) add(at.point, t);
      }
    }
  }
  // As find_sphere_contacts(): the order does not depend on how triangles are numbered.
  const auto key = [](const Contact& c) {
    return std::array{c.normal[0], c.normal[1], c.normal[2], c.core[0], c.core[1], c.core[2]};
  };
  std::sort(out.contacts.begin(), out.contacts.begin() + out.count,
            [&](const Contact& a, const Contact& b) { return key(a) < key(b); });
}

}  // namespace kt
