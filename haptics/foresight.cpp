#include "haptics/foresight.hpp"

#include <limits>

#include "collision/closest_point.hpp"

namespace kt {

std::vector<ContactHold> last_holds(std::span<const LocalReport> reports, double rate_hz) {
  std::vector<ContactHold> out;
  if (reports.empty()) return out;
  const LocalReport& last = reports.back();
  for (const ContactSample& s : std::span(last.samples).first(static_cast<std::size_t>(last.count))) {
    const Vec3 force = rate_hz * s.impulse;
    const double along = s.normal.dot(force);
    out.push_back({.nodes = s.nodes,
                   .bary = s.bary,
                   .normal = s.normal,
                   .point = s.point,
                   .sticks = s.sticks,
                   .force = -along,
                   .friction = force - along * s.normal});
  }
  return out;
}

Vec3 tool_velocity(std::span<const LocalReport> reports, double rate_hz) {
  if (reports.size() < 2) return Vec3::Zero();
  const std::size_t ticks = std::min<std::size_t>(reports.size() - 1, kVelocityTicks);
  return rate_hz / static_cast<double>(ticks) * (reports.back().tool - reports[reports.size() - 1 - ticks].tool);
}

std::vector<ContactHold> moved_holds(std::vector<ContactHold> holds, const Surface& surface, const VectorX& rest,
                                     const Vec3& step) {
  for (ContactHold& hold : holds) {
    hold.point += step;
    if (hold.sticks) {
      hold.friction.setZero();
      continue;
    }
    Vec3 place = step;
    for (int c = 0; c < 3; ++c) place += hold.bary[c] * node(rest, hold.nodes[c]);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : surface.triangles) {
      const Vec3 a = node(rest, t[0]), b = node(rest, t[1]), c = node(rest, t[2]);
      if ((b - a).cross(c - a).dot(hold.normal) <= 0) continue;  // the other side of a thin body
      const ClosestPoint at = closest_point_on_triangle(place, a, b, c);
      if (at.distance_sq >= nearest) continue;
      nearest = at.distance_sq;
      hold.nodes = {t[0], t[1], t[2]};
      hold.bary = at.bary;
    }
  }
  return holds;
}

}  // namespace kt
