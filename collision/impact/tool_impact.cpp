// Conservative advancement with separating planes.
//
// All vertices move linearly relative to the tool. At a time t let n point from the tool's centre to the closest point
// of the triangle: while all three vertices stay further than the radius along n, the tool is free. Those are three
// linear functions of time, so the first time that is not certified free is known exactly; go there and take the next
// plane. When no plane is left, or the steps become smaller than kTimeResolution, that time is the hit. So no contact
// is missed, no time is late, and all feature classes (face, edge, vertex), degenerate triangles and coplanar motion
// take one path. Derivation, and the rounding allowance: docs/collision.md.
#include "collision/impact/tool_impact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/impact/advancement.hpp"
#include "collision/impact/feature_toi.hpp"
#include "collision/shape/closest_point.hpp"
#include "collision/shape/unit_vector.hpp"

namespace kt {
namespace {

constexpr int kMaxPlanes = 100;              // then the time reached is the answer: early, never late
constexpr int kMaxCrossings = 4;             // a point crosses a moving plane at most three times
constexpr double kRounding = 128 * 0x1p-53;  // of the largest relative coordinate: error of a separation
constexpr double kInside = 1e-5;             // of the longest edge: a point this little inside is still on the surface
constexpr double kGrazing = 1e-9;            // of the speed: who leaves slower than this counts as coming

/// Triangle relative to the tool's centre during the step.
struct RelativeTriangle {
  Vec3 at_t0[3], change[3];
  double radius, speed, rounding;

  void place(double t, Vec3 (&out)[3]) const noexcept {
    for (int i = 0; i < 3; ++i) out[i] = at_t0[i] + t * change[i];
  }
  ClosestPoint closest(double t) const noexcept {
    Vec3 now[3];
    place(t, now);
    return closest_point_on_triangle(Vec3::Zero(), now[0], now[1], now[2]);
  }
  /// At most this far apart where first_contact_time() found contact.
  double touching_gap() const noexcept { return 2 * rounding + speed * kTimeResolution; }
  double gap(double t) const noexcept { return std::sqrt(closest(t).distance_sq) - radius; }
  double longest_edge() const noexcept {
    return std::max({(at_t0[1] - at_t0[0]).norm(), (at_t0[2] - at_t0[1]).norm(), (at_t0[0] - at_t0[2]).norm()});
  }
  /// Unit normal, and how far rounding may have turned it [rad]; zero where rounding decides.
  struct FaceNormal {
    Vec3 n = Vec3::Zero();
    double error = 1;
  };
  FaceNormal face_normal(double t) const noexcept {
    Vec3 now[3];
    place(t, now);
    const Vec3 ab = now[1] - now[0], ac = now[2] - now[0], n = ab.cross(ac);
    const double length = n.norm(), longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    if (!(length > 100 * rounding * longest)) return {};
    return {n / length, rounding * longest / length};
  }
  /// Velocity of the surface point `bary` towards the tool, per unit of t.
  Vec3 velocity(const Vec3& bary) const noexcept {
    return bary[0] * change[0] + bary[1] * change[1] + bary[2] * change[2];
  }
};

/// n without its part along the edge; n itself where the edge is no longer than the distance to it: what is along it
/// then is no more than the rounding of places, and of the edge's direction there may be nothing but rounding.
Vec3 across_edge(const Vec3& n, const Vec3& edge, double distance_sq) noexcept {
  const double length_sq = edge.squaredNorm();
  return length_sq > distance_sq ? Vec3(n - n.dot(edge) / length_sq * edge) : n;
}

/// Across the face, to the side of n. As with edges: of a face that is lower than its distance n knows more.
Vec3 across_face(const Vec3 (&now)[3], const Vec3& n, double distance_sq) noexcept {
  const Vec3 ab = now[1] - now[0], bc = now[2] - now[1], ca = now[0] - now[2];
  const double ab_sq = ab.squaredNorm(), bc_sq = bc.squaredNorm(), ca_sq = ca.squaredNorm();
  const Vec3& longest = ab_sq >= bc_sq && ab_sq >= ca_sq ? ab : bc_sq >= ca_sq ? bc : ca;
  const Vec3 area = ab.cross(bc);
  const double length = area.norm();
  const bool is_high = length * length > distance_sq * longest.squaredNorm();
  return across_edge(is_high ? Vec3(area / (area.dot(n) < 0 ? -length : length)) : n, longest, distance_sq);
}

/// From the centre to the closest feature, unit or a little shorter. Close to the surface the closest point itself is
/// mostly rounding; the feature still knows what is across it. Where rounding has turned the direction so far that
/// another vertex seems nearer, what is meant is the edge to it, or the face.
Vec3 direction(const Vec3 (&now)[3], const ClosestPoint& at) noexcept {
  const Vec3 n = at.point / std::sqrt(at.distance_sq);
  if (at.feature == ClosestPoint::Feature::face) return across_face(now, n, at.distance_sq);
  const int i = at.feature_index, k = (i + 1) % 3, m = (i + 2) % 3;
  const auto seems_nearer = [&](const Vec3& to, int j) { return to.dot(now[j] - now[i]) < 0; };
  int along = -1;  // the other end of the edge that n is across
  if (at.feature == ClosestPoint::Feature::edge)
    along = k;
  else if (seems_nearer(n, k))
    along = k;
  else if (seems_nearer(n, m))
    along = m;
  if (along < 0) return n;
  const Vec3 across = across_edge(n, now[along] - now[i], at.distance_sq);
  return seems_nearer(across, along == k ? m : k) ? across_face(now, n, at.distance_sq) : across;
}

/// Contact at time t. The normal of a point tool is the face's; a sphere's goes from the closest point to its centre.
/// Where there is none (a degenerate triangle, a centre on the surface) it faces the motion.
Contact contact_at(const RelativeTriangle& r, double t) noexcept {
  Vec3 now[3];
  r.place(t, now);
  const ClosestPoint at = closest_point_on_triangle(Vec3::Zero(), now[0], now[1], now[2]);
  const double distance = std::sqrt(at.distance_sq);
  Contact out;
  out.bary = at.bary;
  out.normal = r.face_normal(t).n;
  if (r.radius > 0 && distance > r.rounding) out.normal = -direction(now, at).normalized();
  if (out.normal.isZero(0)) {
    out.normal = unit_vector(r.velocity(at.bary));
    if (out.normal.isZero(0)) out.normal = Vec3::UnitZ();
  }
  out.gap = distance - r.radius;
  out.toi = t;
  return out;
}

/// The tool's centre is behind the face.
bool is_behind(const RelativeTriangle& r, double t, const ClosestPoint& at) noexcept {
  return at.feature == ClosestPoint::Feature::face && r.face_normal(t).n.dot(at.point) > 0;
}

/// For how long the plane across n, turning by `turn` (across n) per unit of time, keeps tool and triangle apart.
double free_for(const RelativeTriangle& r, const Vec3 (&now)[3], const Vec3& n, const Vec3& turn) noexcept {
  return separated_for(now, r.change, 3, n, turn, r.radius + r.rounding);
}

/// How the closest feature turns the direction n across it, per unit of time.
Vec3 turning(const RelativeTriangle& r, const Vec3 (&now)[3], const ClosestPoint& at, const Vec3& n) noexcept {
  if (at.feature == ClosestPoint::Feature::vertex) return Vec3::Zero();
  const int i = at.feature_index, k = (i + 1) % 3, m = (i + 2) % 3;
  const Vec3 ab = now[k] - now[i], ab_rate = r.change[k] - r.change[i];
  if (at.feature == ClosestPoint::Feature::edge) return -n.dot(ab_rate) / ab.squaredNorm() * ab;
  const Vec3 ac = now[m] - now[i], ac_rate = r.change[m] - r.change[i];
  const Vec3 area = ab.cross(ac), area_rate = ab_rate.cross(ac) + ab.cross(ac_rate);
  return (area_rate - n.dot(area_rate) * n) / n.dot(area);
}

/// Until when a plane across the closest direction at t keeps tool and triangle apart; t itself when none does.
double free_until(const RelativeTriangle& r, double t) noexcept {
  Vec3 now[3];
  r.place(t, now);
  const ClosestPoint at = closest_point_on_triangle(Vec3::Zero(), now[0], now[1], now[2]);
  const Vec3 n = direction(now, at);
  const double still = free_for(r, now, n, Vec3::Zero());
  if (!(still > 0) || t + still >= 1) return t + still;
  const Vec3 turn = turning(r, now, at, n);
  return t + (turn.allFinite() ? std::max(still, free_for(r, now, n, turn)) : still);
}

double first_contact_time(const RelativeTriangle& r, double from) noexcept {
  return kt::first_contact_time(from, 1, kMaxPlanes, [&](double t) { return free_until(r, t); });
}

/// When a tool that touches at `from` clearly no longer does.
double opening_time(const RelativeTriangle& r, double from) noexcept {
  return kt::opening_time(from, [&](double t) { return r.gap(t) > 2 * r.touching_gap(); });
}

/// The foot of a tool `distance` away is certainly on the face: not where rounding turns the normal of a sliver so far
/// that it may be on an edge, which counts from both sides.
bool is_surely_on_face(const RelativeTriangle& r, const Contact& contact, double distance) noexcept {
  const double turned = r.face_normal(contact.toi).error;  // the rounding over the height
  return contact.bary.minCoeff() > turned * (1 + turned * distance / r.rounding);
}

/// One-sided: a tool that comes through from within is on the way out. Who only grazes, or touches where there is no
/// normal, comes from outside; so does who has not come close when the planes ran out.
bool is_from_within(const RelativeTriangle& r, const Contact& contact) noexcept {
  if (contact.gap > r.touching_gap()) return false;
  if (r.radius > 0)
    return is_behind(r, contact.toi, r.closest(contact.toi)) && is_surely_on_face(r, contact, contact.gap + r.radius);
  const double graze = (kGrazing + r.face_normal(contact.toi).error) * r.speed;
  return contact.normal.dot(r.velocity(contact.bary)) < -graze;
}

/// What the tool does at the start of the step.
struct Start {
  bool is_touching = false, is_outside = false, is_approaching = false;
  Contact contact;
};

Start at_start(const RelativeTriangle& r) noexcept {
  const ClosestPoint at = r.closest(0);
  const double distance = std::sqrt(at.distance_sq);
  const bool behind = is_behind(r, 0, at);
  const bool slightly_inside = r.radius == 0 && behind && distance < kInside * r.longest_edge();
  Start out;
  out.is_touching = slightly_inside || distance - r.radius <= r.rounding;
  if (!out.is_touching) return out;
  out.is_outside = !behind || (r.radius == 0 && distance <= r.rounding);
  out.contact = contact_at(r, 0);
  if (slightly_inside) out.contact.gap = -distance;
  // From a triangle without a normal every way leads away.
  const bool has_normal = r.radius > 0 || !r.face_normal(0).n.isZero(0);
  out.is_approaching = has_normal && out.contact.normal.dot(r.velocity(out.contact.bary)) > 0;
  return out;
}

/// The first contact that counts. `let_pass`: there is one that does not, as the tool leaves or comes from within.
std::optional<Contact> first_impact(const RelativeTriangle& r, const Start& start, bool& let_pass) noexcept {
  double from = 0;
  if (start.is_touching) {
    // Touching: a hit only when the tool comes nearer. If not, contact counts again once the gap has opened; a tool
    // that comes out on the inner side has gone through while it touched.
    if (start.is_approaching && (start.is_outside || r.radius == 0)) return start.contact;
    if (r.speed == 0) return std::nullopt;
    let_pass = true;
    from = opening_time(r, 0);
    if (from < 0) return std::nullopt;
    if (start.is_outside && is_behind(r, from, r.closest(from))) return start.contact;
  }
  for (int crossing = 0;; ++crossing) {
    const double toi = first_contact_time(r, from);
    if (toi < 0) return std::nullopt;
    const Contact contact = contact_at(r, toi);
    if (crossing == kMaxCrossings || !is_from_within(r, contact)) return contact;
    let_pass = true;
    from = opening_time(r, toi);
    if (from < 0) return std::nullopt;
  }
}

/// When the centre of a sphere goes through the triangle from the outside, or -1.
double centre_goes_under(RelativeTriangle r) noexcept {
  r.radius = 0;
  bool let_pass = false;
  const auto hit = first_impact(r, at_start(r), let_pass);
  return hit ? hit->toi : -1;
}

}  // namespace

std::optional<Contact> find_triangle_impact(const ToolShape& tool, const ToolSweep& sweep, const Vec3 (&triangle_t0)[3],
                                            const Vec3 (&triangle_t1)[3]) noexcept {
  RelativeTriangle r;
  r.radius = tool.radius;
  r.speed = 0;
  double size = tool.radius;
  bool finite = std::isfinite(tool.radius);
  for (int i = 0; i < 3; ++i) {
    r.at_t0[i] = triangle_t0[i] - sweep.x_t0;
    const Vec3 at_t1 = triangle_t1[i] - sweep.x_t1;
    r.change[i] = at_t1 - r.at_t0[i];
    r.speed = std::max(r.speed, r.change[i].norm());
    size = std::max({size, r.at_t0[i].lpNorm<Eigen::Infinity>(), at_t1.lpNorm<Eigen::Infinity>()});
    finite = finite && r.at_t0[i].allFinite() && at_t1.allFinite();
  }
  if (!finite || size > kLargestCoordinate || size < kSmallestExtent) return std::nullopt;
  r.rounding = kRounding * size;

  const Start start = at_start(r);
  bool let_pass = false;
  const auto hit = first_impact(r, start, let_pass);
  if (!let_pass || r.radius == 0) return hit;
  // A sphere that was let pass may overlap to the end of the step: not seen again, unless its centre goes under.
  const double under = centre_goes_under(r);
  if (under < 0 || (hit && hit->toi <= under)) return hit;
  return start.is_touching && start.is_outside ? start.contact : contact_at(r, under);
}

}  // namespace kt
