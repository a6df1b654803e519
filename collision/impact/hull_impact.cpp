// Conservative advancement with separating planes, as in tool_impact.cpp, between the corners of the hull and those of
// the triangle: up to nine differences, each linear in time.
#include "collision/impact/hull_impact.hpp"

#include <algorithm>
#include <cmath>

#include "collision/impact/advancement.hpp"
#include "collision/impact/feature_toi.hpp"
#include "collision/shape/closest_point.hpp"
#include "collision/shape/unit_vector.hpp"

namespace kt {
namespace {

constexpr int kMaxPlanes = 200;  // then the time reached is the answer: early, never late
constexpr double kRounding =
    256 * 0x1p-53;                 // of the largest relative coordinate: error of a separation (docs/collision.md)
constexpr double kGrazing = 1e-9;  // of the speed: who leaves slower than this counts as coming

/// Two features and the points of theirs that are closest: the difference is sum weight[i] of the hull's corners minus
/// that of the triangle's.
struct Witness {
  enum class Kind { corner_face, face_corner, edges, corner_edge, edge_corner, corners } kind = Kind::corners;
  Vec3 hull = Vec3::Zero(), triangle = Vec3::Zero();  // weights
  int i = 0, k = 0;                                   // corner, or first corner of the edge: of the hull, the triangle
  Vec3 apart = Vec3::Zero();                          // from the hull to the triangle [m]
  double distance = 0;
};

struct Place {
  Vec3 hull[3], triangle[3];
};

struct Motion {
  Place at_t0, change;
  int corners = 1;
  double radius = 0, speed = 0, rounding = 0;  // radius: with swell
  double swell = 0, until = 1;

  Place at(double t) const noexcept {
    Place out;
    for (int i = 0; i < 3; ++i) {
      out.hull[i] = at_t0.hull[i] + t * change.hull[i];
      out.triangle[i] = at_t0.triangle[i] + t * change.triangle[i];
    }
    return out;
  }
  double touching_gap() const noexcept { return 2 * rounding + speed * kTimeResolution; }
  int edges() const noexcept { return corners == 3 ? 3 : corners - 1; }
};

Witness finish(const Place& p, Witness w) noexcept {
  w.apart = w.triangle[0] * (p.triangle[0] - p.hull[0]) + w.triangle[1] * (p.triangle[1] - p.hull[0]) +
            w.triangle[2] * (p.triangle[2] - p.hull[0]) - w.hull[1] * (p.hull[1] - p.hull[0]) -
            w.hull[2] * (p.hull[2] - p.hull[0]);
  w.distance = w.apart.norm();
  return w;
}

/// Every pair of features with the closest points inside both; where hull and triangle intersect, none need be near.
template <class Visit>
void for_each_witness(const Place& p, int corners, const Visit& visit) noexcept {
  using Feature = ClosestPoint::Feature;
  const auto& [a, b] = p;
  for (int i = 0; i < corners; ++i) {
    const ClosestPoint at = closest_point_on_triangle(a[i], b[0], b[1], b[2]);
    Witness w;
    w.kind = at.feature == Feature::face   ? Witness::Kind::corner_face
             : at.feature == Feature::edge ? Witness::Kind::corner_edge
                                           : Witness::Kind::corners;
    w.hull[i] = 1;
    w.triangle = at.bary;
    w.i = i;
    w.k = at.feature_index;
    visit(finish(p, w));
  }
  for (int k = 0; k < 3 && corners > 1; ++k) {
    Witness w;
    w.triangle[k] = 1;
    w.k = k;
    if (corners == 3) {
      const ClosestPoint at = closest_point_on_triangle(b[k], a[0], a[1], a[2]);
      if (at.feature == Feature::vertex) continue;  // seen above
      w.kind = at.feature == Feature::face ? Witness::Kind::face_corner : Witness::Kind::edge_corner;
      w.hull = at.bary;
      w.i = at.feature_index;
    } else {
      const Vec3 along = a[1] - a[0];
      const double length_sq = along.squaredNorm(), s = length_sq > 0 ? along.dot(b[k] - a[0]) / length_sq : 0;
      if (!(s > 0 && s < 1)) continue;
      w.kind = Witness::Kind::edge_corner;
      w.hull = Vec3(1 - s, s, 0);
    }
    visit(finish(p, w));
  }
  for (int i = 0; i < (corners == 3 ? 3 : corners - 1); ++i)
    for (int k = 0; k < 3; ++k) {
      const int j = (i + 1) % 3, m = (k + 1) % 3;
      const auto [s, t] = closest_parameters(a[i], a[j], b[k], b[m]);
      if (!(s > 0 && s < 1 && t > 0 && t < 1)) continue;
      Witness w;
      w.kind = Witness::Kind::edges;
      w.hull[i] = 1 - s;
      w.hull[j] = s;
      w.triangle[k] = 1 - t;
      w.triangle[m] = t;
      w.i = i;
      w.k = k;
      visit(finish(p, w));
    }
}

Witness closest(const Place& p, int corners) noexcept {
  Witness best;
  best.distance = std::numeric_limits<double>::infinity();
  for_each_witness(p, corners, [&](const Witness& w) {
    if (w.distance < best.distance) best = w;
  });
  return best;
}

Vec3 face_area(const Vec3 (&x)[3]) noexcept { return (x[1] - x[0]).cross(x[2] - x[0]); }
Vec3 face_area_rate(const Vec3 (&x)[3], const Vec3 (&v)[3]) noexcept {
  return (v[1] - v[0]).cross(x[2] - x[0]) + (x[1] - x[0]).cross(v[2] - v[0]);
}
Vec3 without(const Vec3& n, const Vec3& edge) noexcept { return n - n.dot(edge) / edge.squaredNorm() * edge; }

/// Direction of a plane between the two features, unit or a little shorter, from the hull to the triangle, and how they
/// turn it. Close to contact `apart` is mostly rounding; the features still know what is across them.
struct Plane {
  Vec3 n = Vec3::Zero(), turn = Vec3::Zero();
};

Plane plane_between(const Motion& motion, const Place& p, const Witness& w) noexcept {
  Plane out;
  Vec3 area = Vec3::Zero(), rate = Vec3::Zero();
  const auto& [a, b] = p;
  const auto& [va, vb] = motion.change;
  const int j = (w.i + 1) % 3, m = (w.k + 1) % 3;
  switch (w.kind) {
    case Witness::Kind::corner_face:
      area = face_area(b);
      rate = face_area_rate(b, vb);
      break;
    case Witness::Kind::face_corner:
      area = face_area(a);
      rate = face_area_rate(a, va);
      break;
    case Witness::Kind::edges:
      area = (a[j] - a[w.i]).cross(b[m] - b[w.k]);
      rate = (va[j] - va[w.i]).cross(b[m] - b[w.k]) + (a[j] - a[w.i]).cross(vb[m] - vb[w.k]);
      break;
    case Witness::Kind::corner_edge:
    case Witness::Kind::edge_corner: {
      if (!(w.distance > 0)) return out;
      const bool on_triangle = w.kind == Witness::Kind::corner_edge;
      const Vec3 along = on_triangle ? Vec3(b[m] - b[w.k]) : Vec3(a[j] - a[w.i]);
      const Vec3 along_rate = on_triangle ? Vec3(vb[m] - vb[w.k]) : Vec3(va[j] - va[w.i]);
      out.n = without(w.apart / w.distance, along);
      out.turn = -out.n.dot(along_rate) / along.squaredNorm() * along;
      return out;
    }
    case Witness::Kind::corners:
      if (w.distance > 0) out.n = w.apart / w.distance;
      return out;
  }
  const double length = area.norm();
  if (!(length > 0)) {
    if (w.distance > 0) out.n = w.apart / w.distance;
    return out;
  }
  out.n = area / (area.dot(w.apart) < 0 ? -length : length) * (1 - 1e-15);
  out.turn = (rate - out.n.dot(rate) * out.n) / out.n.dot(area);
  return out;
}

/// Until when a plane keeps hull and triangle apart; t itself when none does.
double free_until(const Motion& motion, double t) noexcept {
  const Place p = motion.at(t);
  const Plane plane = plane_between(motion, p, closest(p, motion.corners));
  if (!plane.n.allFinite()) return t;
  Vec3 now[9], change[9];
  int count = 0;
  for (int i = 0; i < motion.corners; ++i)
    for (int k = 0; k < 3; ++k, ++count) {
      now[count] = p.triangle[k] - p.hull[i];
      change[count] = motion.change.triangle[k] - motion.change.hull[i];
    }
  const double reach = motion.radius + motion.rounding;
  const double still = separated_for(now, change, count, plane.n, Vec3(Vec3::Zero()), reach);
  if (!(still > 0) || t + still >= 1 || !plane.turn.allFinite()) return t + still;
  return t + std::max(still, separated_for(now, change, count, plane.n, plane.turn, reach));
}

double first_contact_time(const Motion& motion, double from) noexcept {
  return kt::first_contact_time(from, motion.until, kMaxPlanes, [&](double t) { return free_until(motion, t); });
}

/// An edge of one goes through the inside of the other.
bool is_pierced(const Place& p, int corners) noexcept {
  const auto pierces = [](const Vec3& from, const Vec3& to, const Vec3(&face)[3]) {
    const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
      return (b - a).cross(c - a).dot(d - a);
    };
    const double low = volume(face[0], face[1], face[2], from), high = volume(face[0], face[1], face[2], to);
    if (!(low * high < 0)) return false;
    const double u = volume(from, to, face[0], face[1]), v = volume(from, to, face[1], face[2]),
                 w = volume(from, to, face[2], face[0]);
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
  };
  for (int i = 0; i < (corners == 3 ? 3 : corners - 1); ++i)
    if (pierces(p.hull[i], p.hull[(i + 1) % 3], p.triangle)) return true;
  for (int k = 0; k < 3 && corners == 3; ++k)
    if (pierces(p.triangle[k], p.triangle[(k + 1) % 3], p.hull)) return true;
  return false;
}

double gap(const Motion& motion, double t) noexcept {
  const Place p = motion.at(t);
  const double distance = is_pierced(p, motion.corners) ? 0 : closest(p, motion.corners).distance;
  return distance - motion.radius;
}

/// When a hull that touches at `from` clearly no longer does.
double opening_time(const Motion& motion, double from) noexcept {
  return kt::opening_time(from, [&](double t) { return gap(motion, t) > 2 * motion.touching_gap(); });
}

/// The hull's corner is behind the triangle's face.
bool is_behind(const Place& p, const Witness& w) noexcept {
  return w.kind == Witness::Kind::corner_face && face_area(p.triangle).dot(w.apart) > 0;
}

/// Of the closest points towards one another, per unit of time.
double approach(const Motion& motion, const Witness& w, const Vec3& n) noexcept {
  Vec3 rate = Vec3::Zero();
  for (int i = 0; i < 3; ++i) rate += w.hull[i] * motion.change.hull[i] - w.triangle[i] * motion.change.triangle[i];
  return rate.dot(n);
}

Contact contact_at(const Motion& motion, const Place& p, double t, const Witness& w) noexcept {
  Contact out;
  out.bary = w.triangle;
  out.normal = -unit_vector(plane_between(motion, p, w).n);
  if (!(out.normal.squaredNorm() > 0.5)) {
    Vec3 rate = Vec3::Zero();
    for (int i = 0; i < 3; ++i) rate += w.triangle[i] * motion.change.triangle[i] - w.hull[i] * motion.change.hull[i];
    out.normal = unit_vector(rate);
    if (out.normal.isZero(0)) out.normal = Vec3::UnitZ();
  }
  // A hull without a radius that is a rounding below the face is still above it.
  if (w.kind == Witness::Kind::corner_face && motion.radius == 0) {
    const Vec3 upwards = unit_vector(face_area(p.triangle));
    if (!upwards.isZero(0)) out.normal = upwards;
  }
  out.gap = w.distance - motion.radius;
  out.toi = t;
  return out;
}

/// The contact at the start that is closing fastest, if one is: an extended tool can lift at one place and sink at
/// another.
std::optional<Contact> closing_at_start(const Motion& motion, bool& is_touching) noexcept {
  const Place p = motion.at(0);
  is_touching = is_pierced(p, motion.corners);
  std::optional<Contact> out;
  double fastest = 0;
  for_each_witness(p, motion.corners, [&](const Witness& w) {
    if (w.distance - motion.radius > motion.rounding) return;
    is_touching = true;
    if (motion.radius > 0 && is_behind(p, w)) return;
    const Contact contact = contact_at(motion, p, 0, w);
    const double speed = approach(motion, w, -contact.normal);
    if (!(speed > fastest)) return;
    fastest = speed;
    out = contact;
  });
  return out;
}

bool is_from_within(const Motion& motion, const Place& p, const Witness& w, const Contact& contact) noexcept {
  if (contact.gap > motion.touching_gap() || w.kind != Witness::Kind::corner_face) return false;
  if (motion.radius > 0) return is_behind(p, w);
  return approach(motion, w, -contact.normal) < -kGrazing * motion.speed;
}

/// One plane keeps the two apart at both ends, hence all the time, to within rounding: what rests, slides or leaves.
bool stays_apart(const Motion& motion) noexcept {
  const Place p = motion.at(0);
  const Plane plane = plane_between(motion, p, closest(p, motion.corners));
  if (!plane.n.allFinite() || plane.n.isZero(0)) return false;
  const double reach = motion.radius - motion.rounding;
  for (int i = 0; i < motion.corners; ++i)
    for (int k = 0; k < 3; ++k) {
      const double now = plane.n.dot(p.triangle[k] - p.hull[i]);
      if (!(std::min(now, now + plane.n.dot(motion.change.triangle[k] - motion.change.hull[i])) >= reach)) return false;
    }
  return true;
}

/// It touched all the time, nowhere closed at the start, and is inside at the end: then it was hit at the start.
std::optional<Contact> sunk_in(const Motion& motion) noexcept {
  const Place start = motion.at(0), end = motion.at(1);
  const Witness w = closest(start, motion.corners), last = closest(end, motion.corners);
  const double radius = motion.radius - motion.swell;  // at both ends nothing is off its line
  const bool was_in = is_pierced(start, motion.corners) || w.distance - radius < -motion.touching_gap();
  const bool is_in = is_pierced(end, motion.corners) || last.distance - radius < -4 * motion.touching_gap();
  if (was_in || !is_in) return std::nullopt;
  return contact_at(motion, start, 0, w);
}

}  // namespace

std::optional<Contact> find_hull_impact(const MovingHull& hull, const Vec3 (&triangle_t0)[3],
                                        const Vec3 (&triangle_t1)[3], double until) noexcept {
  Motion motion;
  motion.corners = hull.corners;
  motion.radius = hull.radius + hull.swell;
  motion.swell = hull.swell;
  double size = motion.radius;
  bool finite = std::isfinite(size);
  const Vec3 from = hull.x_t0[0], to = hull.x_t1[0];  // relative to a corner: nothing is lost far from the origin
  for (int i = 0; i < 3; ++i) {
    const int c = std::min(i, hull.corners - 1);
    motion.at_t0.hull[i] = hull.x_t0[c] - from;
    motion.at_t0.triangle[i] = triangle_t0[i] - from;
    const Vec3 hull_t1 = hull.x_t1[c] - to, triangle_t1_i = triangle_t1[i] - to;
    motion.change.hull[i] = hull_t1 - motion.at_t0.hull[i];
    motion.change.triangle[i] = triangle_t1_i - motion.at_t0.triangle[i];
    motion.speed = std::max(motion.speed, motion.change.triangle[i].norm() + motion.change.hull[i].norm());
    for (const Vec3& v : {motion.at_t0.hull[i], motion.at_t0.triangle[i], hull_t1, triangle_t1_i}) {
      size = std::max(size, v.lpNorm<Eigen::Infinity>());
      finite = finite && v.allFinite();
    }
  }
  if (!finite || size > kLargestCoordinate || size < kSmallestExtent) return std::nullopt;
  motion.rounding = kRounding * size;

  motion.until = until;
  if (stays_apart(motion)) return std::nullopt;

  double start = 0;
  bool is_touching = false;
  if (const std::optional<Contact> closing = closing_at_start(motion, is_touching)) return closing;
  if (is_touching) {
    if (motion.speed == 0) return std::nullopt;
    start = opening_time(motion, 0);
    if (start < 0) return sunk_in(motion);
  }
  constexpr int kMaxCrossings = 4;
  for (int crossing = 0;; ++crossing) {
    const double toi = first_contact_time(motion, start);
    if (toi < 0) return std::nullopt;
    const Place p = motion.at(toi);
    const Witness w = closest(p, motion.corners);
    const Contact contact = contact_at(motion, p, toi, w);
    if (crossing == kMaxCrossings || !is_from_within(motion, p, w, contact)) return contact;
    start = opening_time(motion, toi);
    if (start < 0) return std::nullopt;
  }
}

double sagitta(double arm, double angle) noexcept {
  return std::abs(angle) < M_PI ? arm * (1 - std::cos(0.5 * angle)) : 2 * arm;
}

}  // namespace kt
