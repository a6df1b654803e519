#include "haptics/touched/contact_length.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

double push_of(const TickContact& contact) { return std::max(0.0, -contact.impulse.dot(contact.normal)); }

std::optional<ContactLength> contact_length(const ToolShape& shape, const Quaternion& turned,
                                            std::span<const TickContact> contacts, int tool) {
  constexpr int kFewest = 3;
  if (shape.kind != ToolShape::Kind::capsule) return std::nullopt;
  ContactLength out;
  Vec3 normal = Vec3::Zero();
  double force = 0, length_sq = 0, width_sq = 0;
  int count = 0;
  for (const TickContact& c : contacts) {
    if (c.tool != tool) continue;
    force += push_of(c);
    normal += push_of(c) * c.normal;
    out.middle += push_of(c) * c.point;
    ++count;
  }
  if (count < kFewest || !(normal.norm() > 0)) return std::nullopt;
  normal.normalize();
  out.middle /= force;
  const Vec3 axis = turned * (shape.corners[1] - shape.corners[0]).normalized();
  out.along = (axis - axis.dot(normal) * normal).normalized();
  const Vec3 across = normal.cross(out.along);
  for (const TickContact& c : contacts) {
    if (c.tool != tool) continue;
    const double s = (c.point - out.middle).dot(out.along), w = (c.point - out.middle).dot(across);
    length_sq += push_of(c) / force * s * s;
    width_sq += push_of(c) / force * w * w;
  }
  out.half_length = std::sqrt(3 * length_sq);
  out.half_width = 2 * std::sqrt(width_sq);
  if (!(out.half_length > kStaysLong * out.half_width)) return std::nullopt;
  return out;
}

}  // namespace kt
