// Certified root search on the gap g(t) = distance(tool centre, triangle) - radius along the step.
//
// All vertices move linearly relative to the tool, so g changes by at most L = max |relative vertex displacement| per
// unit of t. From values at two times, |t' - t| < g(t) / L around each is free of contact: that is trimmed away, the
// rest is bisected, earlier half first. What cannot be shown free down to kResolution is a hit at its lower end. So no
// contact is missed, no time is late, and all feature classes (face, edge, vertex), degenerate triangles and coplanar
// motion take one path. Derivation of the rounding allowance: docs/collision.md.
#include "collision/ccd.hpp"

#include <algorithm>
#include <cmath>

#include "collision/closest_point.hpp"

namespace kt {
namespace {

constexpr double kResolution = 0x1p-42;     // of the step: 2e-13
constexpr int kMaxEvaluations = 400;        // then the earliest open interval is the answer (early, never late)
constexpr double kRounding = 64 * 0x1p-53;  // of the largest relative coordinate: error of one gap evaluation
constexpr double kInside = 1e-5;            // of the longest edge: a point this little inside is still on the surface

/// Triangle relative to the tool's centre, at both ends of the step.
struct RelativeTriangle {
  Vec3 at_t0[3], change[3];
  double radius;

  void place(double t, Vec3 (&out)[3]) const noexcept {
    for (int i = 0; i < 3; ++i) out[i] = at_t0[i] + t * change[i];
  }
  ClosestPoint closest(double t) const noexcept {
    Vec3 now[3];
    place(t, now);
    return closest_point_on_triangle(Vec3::Zero(), now[0], now[1], now[2]);
  }
  double gap(double t) const noexcept { return std::sqrt(closest(t).distance_sq) - radius; }
  Vec3 face_normal(double t) const noexcept {
    Vec3 now[3];
    place(t, now);
    const Vec3 n = (now[1] - now[0]).cross(now[2] - now[0]);
    const double length = n.norm();
    return length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
  }
  /// Speed at which the tool comes towards the surface point `bary` along `normal`, per unit of t.
  double approach(const Vec3& bary, const Vec3& normal) const noexcept {
    return normal.dot(bary[0] * change[0] + bary[1] * change[1] + bary[2] * change[2]);
  }
};

/// Contact at time t. The normal of a point tool is the face's; a sphere's goes from the closest point to its centre.
Contact contact_at(const RelativeTriangle& r, double t) noexcept {
  const ClosestPoint at = r.closest(t);
  const double distance = std::sqrt(at.distance_sq);
  Contact out;
  out.bary = at.bary;
  out.normal = r.face_normal(t);
  if ((r.radius > 0 && distance > 0) || out.normal.isZero(0))
    out.normal = distance > 0 ? Vec3(-at.point / distance) : Vec3(Vec3::UnitZ());
  out.gap = distance - r.radius;
  out.toi = t;
  return out;
}

/// Touching at the start: a hit only when the tool comes nearer.
std::optional<Contact> touching_at_start(const RelativeTriangle& r, double rounding, bool& is_touching) noexcept {
  const ClosestPoint at = r.closest(0);
  const double distance = std::sqrt(at.distance_sq);
  const Vec3 face = r.face_normal(0);
  double longest = 0;
  for (int i = 0; i < 3; ++i) longest = std::max(longest, (r.at_t0[(i + 1) % 3] - r.at_t0[i]).norm());
  const bool slightly_inside = r.radius == 0 && at.feature == ClosestPoint::Feature::face && face.dot(-at.point) < 0 &&
                               distance < kInside * longest;
  is_touching = slightly_inside || distance - r.radius <= rounding;
  if (!is_touching) return std::nullopt;
  Contact contact = contact_at(r, 0);
  if (slightly_inside) contact.gap = -distance;
  const bool outside = r.radius == 0 || face.dot(-at.point) >= 0 || at.feature != ClosestPoint::Feature::face;
  if (outside && r.approach(contact.bary, contact.normal) > 0) return contact;
  return std::nullopt;
}

/// First interval of [low, high] that cannot be shown free of contact; its lower end, or -1.
double first_open_time(const RelativeTriangle& r, double low, double high, double speed, double rounding) noexcept {
  struct Interval {
    double low, high, gap_low, gap_high;
  };
  Interval stack[48];  // one entry per bisection level that still has a right half
  int depth = 0;
  stack[depth++] = {low, high, r.gap(low), r.gap(high)};
  int evaluations = 2;
  while (depth > 0) {
    Interval now = stack[--depth];
    const double free_low = std::max(0.0, now.gap_low - rounding) / speed;
    const double free_high = std::max(0.0, now.gap_high - rounding) / speed;
    // Rounding of the division and sum must not trim too far: a part in 1e-15 less is enough.
    const double begin = now.low + free_low * (1 - 1e-15), end = now.high - free_high * (1 - 1e-15);
    if (begin > end) continue;
    if (end - begin <= kResolution || evaluations >= kMaxEvaluations || depth + 2 > 48) return std::max(now.low, begin);
    const double middle = 0.5 * (begin + end);
    const double gap_begin = r.gap(begin), gap_middle = r.gap(middle), gap_end = r.gap(end);
    evaluations += 3;
    stack[depth++] = {middle, end, gap_middle, gap_end};
    stack[depth++] = {begin, middle, gap_begin, gap_middle};
  }
  return -1;
}

}  // namespace

std::optional<Contact> find_triangle_impact(const ToolShape& tool, const ToolSweep& sweep, const Vec3 (&triangle_t0)[3],
                                            const Vec3 (&triangle_t1)[3]) noexcept {
  RelativeTriangle r;
  r.radius = tool.radius;
  double speed = 0, size = 0;
  bool finite = true;
  for (int i = 0; i < 3; ++i) {
    r.at_t0[i] = triangle_t0[i] - sweep.x_t0;
    const Vec3 at_t1 = triangle_t1[i] - sweep.x_t1;
    r.change[i] = at_t1 - r.at_t0[i];
    speed = std::max(speed, r.change[i].norm());
    size = std::max({size, r.at_t0[i].lpNorm<Eigen::Infinity>(), at_t1.lpNorm<Eigen::Infinity>()});
    finite = finite && r.at_t0[i].allFinite() && at_t1.allFinite();
  }
  if (!finite || !std::isfinite(speed)) return std::nullopt;
  const double rounding = kRounding * std::max(size, tool.radius);
  speed *= 1 + 1e-14;

  bool is_touching = false;
  if (const auto contact = touching_at_start(r, rounding, is_touching)) return contact;
  if (speed == 0) return std::nullopt;
  double from = 0;
  if (is_touching) {
    // Touching and not approaching: contact counts again once the gap has opened.
    for (from = 0x1p-20; from < 1 && r.gap(from) <= rounding; from *= 2) {
    }
    if (from >= 1) return std::nullopt;
  }
  const double toi = first_open_time(r, from, 1, speed, rounding);
  if (toi < 0) return std::nullopt;

  const Contact contact = contact_at(r, toi);
  // One-sided: who comes through from within is on the way out. A tool that only grazes counts as a hit.
  const double approach = r.approach(contact.bary, r.radius > 0 ? contact.normal : r.face_normal(toi));
  if (approach < -1e-9 * speed) return std::nullopt;
  if (r.radius > 0 && r.closest(toi).feature == ClosestPoint::Feature::face &&
      r.face_normal(toi).dot(contact.normal) < 0)
    return std::nullopt;
  return contact;
}

}  // namespace kt
