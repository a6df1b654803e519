#include "haptics/refresh/seen_tool.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/ticks.hpp"
#include "haptics/refresh/look_ahead.hpp"
#include "haptics/touched/contact_length.hpp"

namespace kt {
namespace {

/// Some of them, of a tool of many corners.
std::vector<Vec3> core_points(const ToolShape& shape, const Pose& pose) {
  constexpr std::size_t kMost = 64;
  if (shape.corners.empty()) return {pose.x};
  const std::size_t step = (shape.corners.size() + kMost - 1) / kMost;
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < shape.corners.size(); i += step) out.push_back(pose.x + pose.r * shape.corners[i]);
  return out;
}

/// Radius of the contact of a tool from where its force was distributed over in the last tick [m]: of a ball
/// a^2 = 2.5 times the mean square distance from the middle (Hertz's pressure), and no less than the farthest that
/// pushes is away, since nodes of a scan lie unevenly; 0: of fewer than three contacts.
double measured_contact_radius(std::span<const TickContact> contacts, int tool) {
  constexpr double kLeast = 0.25;
  constexpr double kPushes = 0.01;  // of the mean force of a contact
  double force = 0, spread = 0, farthest_sq = 0;
  Vec3 middle = Vec3::Zero();
  int count = 0;
  for (const TickContact& c : contacts) {
    if (c.tool != tool) continue;
    ++count;
    force += push_of(c);
    middle += push_of(c) * c.point;
  }
  if (count < 3 || !(force > 0)) return 0;
  middle /= force;
  for (const TickContact& c : contacts) {
    if (c.tool != tool) continue;
    double spacing_sq = std::numeric_limits<double>::infinity();
    for (const TickContact& other : contacts)
      if (other.tool == tool && &other != &c) spacing_sq = std::min(spacing_sq, (other.point - c.point).squaredNorm());
    const double apart_sq = (c.point - middle).squaredNorm();
    if (push_of(c) * count > kPushes * force) farthest_sq = std::max(farthest_sq, apart_sq);
    // A node stands for what lies around it: a pressure shared out to nodes s apart is spread by s^2 / 3 more.
    spread += push_of(c) * std::max(apart_sq - spacing_sq / 3, kLeast * apart_sq);
  }
  return std::sqrt(std::max(2.5 * spread / force, farthest_sq));
}

/// Over the last 16 ms. On a scan tools are held at few places, others from tick to tick: the radius of one tick is
/// up to twice that of the next, and each makes another zone.
double mean_contact_radius(std::span<const LocalReport> reports, double rate_hz, int tool) {
  constexpr double kTime = 0.016;  // [s]
  double sum = 0;
  int count = 0;
  for (const LocalReport& report : reports.last(std::min<std::size_t>(ticks_in(kTime, rate_hz), reports.size()))) {
    const double radius = measured_contact_radius(report.contacts(), tool);
    if (!(radius > 0)) continue;
    sum += radius;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

/// Mean normal of the contacts of a tool by force, unit; zero: none pushes.
Vec3 measured_normal(std::span<const TickContact> contacts, int tool) {
  Vec3 sum = Vec3::Zero();
  for (const TickContact& c : contacts)
    if (c.tool == tool) sum += push_of(c) * c.normal;
  return sum.norm() > 0 ? Vec3(sum.normalized()) : sum;
}

/// Adds where a tool touched the body in the last tick, in the middle of its contacts by force, and along which length.
/// @param length  of the contact as it is now; none: it is about round
void see_contact(const TouchedBody& body, const LocalReport& report, int tool,
                 const std::optional<ContactLength>& length, SeenTool& out) {
  double force = 0, length_sq = 0;
  Vec3 middle = Vec3::Zero(), moves = Vec3::Zero(), stretch = Vec3::Zero();
  for (const TickContact& contact : report.contacts()) {
    if (contact.tool != tool) continue;
    const double push = push_of(contact), s = length ? (contact.point - length->middle).dot(length->along) : 0;
    const Vec3 bary = body.nodes.on_triangle(report.model_frame, contact).bary;
    const Triangle& t = body.surface.triangles[contact.triangle];
    force += push;
    length_sq += push * s * s;
    for (int i = 0; i < 3; ++i) {
      middle += push * bary[i] * node(body.rest, t[i]);
      moves += push * bary[i] * node(body.v, t[i]);
      stretch += push * s * bary[i] * node(body.rest, t[i]);
    }
  }
  if (!(force > 0)) return;
  moves /= force;
  out.touched = middle / force;
  out.velocity -= moves - moves.dot(out.normal) * out.normal;  // along the normal it yields to the tool
  if (!length || !(length_sq > 0)) return;
  out.half_length = length->half_length / length_sq * stretch;  // s has a mean of zero
  out.half_width = length->half_width;
}

/// The one that carries most, of a ball; of a tool that touches far from its reference point the patch reaches as far
/// around that.
int touched_triangle(const ToolShape& shape, const Vec3& place, const LocalReport& report, int tool) {
  int out = report.tools[static_cast<std::size_t>(tool)].triangle;
  if (shape.corners.empty() || out < 0) return out;
  double nearest_sq = std::numeric_limits<double>::infinity();
  for (const TickContact& c : report.contacts()) {
    if (c.tool != tool || !(push_of(c) > 0)) continue;
    if (const double away_sq = (c.point - place).squaredNorm(); away_sq < nearest_sq) {
      nearest_sq = away_sq;
      out = c.triangle;
    }
  }
  return out;
}

}  // namespace

double pressed_radius(const ToolShape& shape, double radius, double way) {
  const double pressed =
      std::sqrt(radius * radius + std::max(shape.radius, 0.3 * tool_reach(shape)) * std::max(0.0, way));
  return shape.kind == ToolShape::Kind::sphere ? std::min(pressed, shape.radius) : pressed;
}

double contact_extent(const ToolShape& shape, const SeenTool& seen, bool models_come_late) {
  constexpr double kBall = 1.41, kElse = 2;  // contact radii
  if (!(seen.contact_radius > 0) || shape.corners.size() > 2) return 0;
  const bool is_soon = shape.kind == ToolShape::Kind::sphere && !models_come_late;
  return (is_soon ? kBall : kElse) *
         pressed_radius(shape, seen.contact_radius, -seen.time * seen.velocity.dot(seen.normal));
}

SeenTool see_tool(const TouchedBody& body, const ToolShape& shape, const Pose& at, std::span<const LocalReport> reports,
                  int tool, double rate_hz) {
  SeenTool out{.core = core_points(shape, at), .velocity = tool_velocity(reports, rate_hz, tool)};
  if (reports.empty()) return out;
  const std::span<const TickContact> contacts = reports.back().contacts();
  out.contact_radius =
      body.surface.embedded ? mean_contact_radius(reports, rate_hz, tool) : measured_contact_radius(contacts, tool);
  out.normal = measured_normal(contacts, tool);
  out.triangle = touched_triangle(shape, at.x, reports.back(), tool);
  see_contact(body, reports.back(), tool, contact_length(shape, at.r, contacts, tool), out);
  return out;
}

}  // namespace kt
