#include "collision/held/surface_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "collision/held/chosen_places.hpp"
#include "collision/shape/closest_point.hpp"

namespace kt {
namespace {

ClosestPoint closest(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& p) noexcept {
  const Triangle& t = patch.triangles[triangle];
  return closest_point_on_triangle(p, node(x, t[0]), node(x, t[1]), node(x, t[2]));
}

bool has(const Triangle& t, int vertex) noexcept { return std::ranges::find(t, vertex) != t.end(); }

/// Calls visit(t) for the triangles that share the closest feature with `triangle`, itself left out, until it answers
/// false; returns whether all answered true.
template <class Visit>
bool all_sharing(const SurfacePatch& patch, int triangle, const ClosestPoint& at, Visit visit) noexcept {
  if (at.feature == ClosestPoint::Feature::face) return true;
  const Triangle& own = patch.triangles[triangle];
  const int a = own[at.feature_index];
  const int b = own[(at.feature_index + 1) % 3];
  for (int t : patch.topology.triangles_of(a)) {
    if (t == triangle) continue;
    const Triangle& other = patch.triangles[t];
    const bool shares = at.feature == ClosestPoint::Feature::vertex || has(other, b);
    if (shares && !visit(t)) return false;
  }
  return true;
}

}  // namespace

void ContactSet::add(const Contact& contact) noexcept {
  if (count < kMaxContacts) {
    contacts[count++] = contact;
    return;
  }
  // Where a neighbour at distance d has the gap g, a surface of this slope has at least g - slope d.
  constexpr double kSlope = 0.1;
  const auto told_by_others = [&](const Contact& c) {
    double most = -std::numeric_limits<double>::infinity();
    const auto tell = [&](const Contact& other) {
      const double higher = c.gap - other.gap;
      if (&other != &c && higher > most) most = std::max(most, higher - kSlope * (c.core - other.core).norm());
    };
    for (const Contact& other : contacts) tell(other);
    tell(contact);
    return most;
  };
  Contact* known = nullptr;
  double best = told_by_others(contact);
  for (Contact& c : contacts)
    if (const double told = told_by_others(c); told > best) {
      best = told;
      known = &c;
    }
  if (known) *known = contact;
}

Vec3 face_normal(const SurfacePatch& patch, const VectorX& x, int triangle) noexcept {
  const Triangle& t = patch.triangles[triangle];
  const Vec3 a = node(x, t[0]);
  const Vec3 n = (node(x, t[1]) - a).cross(node(x, t[2]) - a);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
}

Vec3 vertex_normal(const SurfacePatch& patch, const VectorX& x, int vertex) noexcept {
  Vec3 sum = Vec3::Zero();
  for (int t : patch.topology.triangles_of(vertex)) {
    const Triangle& v = patch.triangles[t];
    const Vec3 a = node(x, v[0]);
    sum += (node(x, v[1]) - a).cross(node(x, v[2]) - a);
  }
  const double length = sum.norm();
  return length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

namespace {

/// The wall that a triangle belongs to at one of its vertices; see find_walls().
int wall_of(const SurfacePatch& patch, int triangle, int vertex) noexcept {
  if (patch.wall.empty()) return 0;
  const Triangle& t = patch.triangles[triangle];
  return patch.wall[triangle][std::ranges::find(t, vertex) - t.begin()];
}

/// Each of two triangles stands up from the other's face, also as the body is dented now.
bool face_each_other(const SurfacePatch& patch, const VectorX& x, int a, const Vec3& normal_a, int b,
                     const Vec3& normal_b) noexcept {
  constexpr double kFlat = 0.9;  // cosine
  if (!(normal_a.dot(normal_b) < kFlat)) return false;
  Vec3 from_a_to_b = Vec3::Zero();  // between the centroids, times 3
  for (int c = 0; c < 3; ++c) from_a_to_b += node(x, patch.triangles[b][c]) - node(x, patch.triangles[a][c]);
  return normal_a.dot(from_a_to_b) > 0 && normal_b.dot(from_a_to_b) < 0;
}

/// vertex_normal() of the wall that one of the triangles there belongs to.
Vec3 wall_normal(const SurfacePatch& patch, const VectorX& x, int triangle, int vertex) noexcept {
  const int own = wall_of(patch, triangle, vertex);
  Vec3 sum = Vec3::Zero();
  for (const int t : patch.topology.triangles_of(vertex)) {
    if (wall_of(patch, t, vertex) != own) continue;
    const Triangle& v = patch.triangles[t];
    const Vec3 a = node(x, v[0]);
    sum += (node(x, v[1]) - a).cross(node(x, v[2]) - a);
  }
  const double length = sum.norm();
  return length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

}  // namespace

Vec3 blended_normal(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& bary) noexcept {
  const Triangle& t = patch.triangles[triangle];
  Vec3 n = Vec3::Zero();
  for (int c = 0; c < 3; ++c) n += bary[c] * wall_normal(patch, x, triangle, t[c]);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : face_normal(patch, x, triangle);
}

namespace {

/// Normal that decides on which side of the closest feature a point lies: the face's, the sum of both faces' at an
/// edge, the angle-weighted sum at a vertex (Baerentzen and Aanaes 2005). Not normalized.
Vec3 side_normal(const SurfacePatch& patch, const VectorX& x, int triangle, const ClosestPoint& at) noexcept {
  Vec3 sum = face_normal(patch, x, triangle);
  if (at.feature == ClosestPoint::Feature::edge)
    all_sharing(patch, triangle, at, [&](int other) {
      sum += face_normal(patch, x, other);
      return true;
    });
  if (at.feature != ClosestPoint::Feature::vertex) return sum;
  const int vertex = patch.triangles[triangle][at.feature_index];
  sum.setZero();
  for (int t : patch.topology.triangles_of(vertex)) {
    const Triangle& v = patch.triangles[t];
    const auto corner = static_cast<std::size_t>(std::ranges::find(v, vertex) - v.begin());
    const Vec3 a = node(x, v[corner]);
    const Vec3 b = node(x, v[(corner + 1) % 3]) - a, c = node(x, v[(corner + 2) % 3]) - a;
    sum += std::atan2(b.cross(c).norm(), b.dot(c)) * face_normal(patch, x, t);
  }
  return sum;
}

}  // namespace

Contact track_point_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& p, int start) noexcept {
  int best = start;
  ClosestPoint at = closest(patch, x, start, p);
  for (bool improved = true; improved;) {
    improved = false;
    const int from = best;
    for (int v : patch.triangles[from])
      for (int t : patch.topology.triangles_of(v)) {
        const ClosestPoint other = closest(patch, x, t, p);
        if (other.distance_sq < at.distance_sq) {
          at = other;
          best = t;
          improved = true;
        }
      }
  }
  Contact contact;
  contact.triangle = best;
  contact.bary = at.bary;
  contact.normal = blended_normal(patch, x, best, at.bary);
  const Vec3 side = side_normal(patch, x, best, at).normalized();
  // In a sharp fold the blended normal can lie across the surface: then it says nothing about where the tool should go.
  constexpr double kAcross = 0.2;
  if (!(contact.normal.dot(side) > kAcross)) contact.normal = side;
  contact.gap = std::copysign(std::sqrt(at.distance_sq), side.dot(p - at.point));
  contact.core = p;
  return contact;
}

Contact nearest_point_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& p) noexcept {
  int nearest = 0;
  double distance_sq = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(patch.triangles.size()); ++t)
    if (const double d = closest(patch, x, t, p).distance_sq; d < distance_sq) {
      distance_sq = d;
      nearest = t;
    }
  return track_point_contact(patch, x, p, nearest);
}

void find_point_contacts(const SurfacePatch& patch, const VectorX& x, const Vec3& p, int start,
                         ContactSet& out) noexcept {
  out.count = 0;
  out.add(track_point_contact(patch, x, p, start));
  if (patch.wall.empty()) return;
  Contact& first = out.contacts[0];
  const Triangle& own = patch.triangles[first.triangle];
  const Vec3 face = face_normal(patch, x, first.triangle);
  std::array<int, 3 * kMaxContacts> seen;
  int num_seen = 0;
  bool is_between = false;  // of two walls, inside both: on neither face
  for (const int v : own)
    for (const int t : patch.topology.triangles_of(v)) {
      if (wall_of(patch, t, v) == wall_of(patch, first.triangle, v)) continue;
      if (std::find(seen.begin(), seen.begin() + num_seen, t) != seen.begin() + num_seen) continue;
      if (num_seen < static_cast<int>(seen.size())) seen[num_seen++] = t;
      const Vec3 normal = face_normal(patch, x, t);
      if (!face_each_other(patch, x, first.triangle, face, t, normal)) continue;
      const ClosestPoint at = closest(patch, x, t, p);
      const bool is_shared = at.feature == ClosestPoint::Feature::edge &&
                             has(own, patch.triangles[t][at.feature_index]) &&
                             has(own, patch.triangles[t][(at.feature_index + 1) % 3]);
      if (at.feature != ClosestPoint::Feature::face && !is_shared) continue;
      const Contact wall{t, at.bary, blended_normal(patch, x, t, at.bary), normal.dot(p - at.point), 0, p};
      is_between = is_between || (is_shared && wall.gap < 0);
      constexpr double kSameWall = 0.95;  // cosine
      Contact* same = std::find_if(out.contacts.data() + 1, out.contacts.data() + out.count,
                                   [&](const Contact& c) { return c.normal.dot(wall.normal) > kSameWall; });
      if (same == out.end())
        out.add(wall);
      else if (at.distance_sq < closest(patch, x, same->triangle, p).distance_sq)
        *same = wall;
    }
  if (is_between && first.gap < 0) first.gap = face.dot(p - node(x, own[0]));
}

namespace {

/// The smooth surface's normal: where a sphere rolls into a fold of two pieces the nearest point leaps, and with it the
/// direction to the centre. At sharp edges that direction is right: at most so far from it.
Vec3 smoothed(const Vec3& to_centre, const Vec3& blended) noexcept {
  constexpr double kMost = 0.2;  // [rad]
  const Vec3 off = blended - to_centre;
  const double size = off.norm();
  return size > kMost ? Vec3((to_centre + kMost / size * off).normalized()) : blended;
}

}  // namespace

std::optional<Contact> find_sphere_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& centre,
                                           double radius, double margin, int triangle) noexcept {
  const double limit = radius + margin;
  const ClosestPoint at = closest(patch, x, triangle, centre);
  if (at.distance_sq > limit * limit) return std::nullopt;
  // A local minimum of the distance: no triangle that shares the closest feature is nearer. Ties (the same edge or
  // vertex seen from several triangles) go to the lowest index.
  const double tie = 1e-12 * (at.distance_sq + radius * radius);
  Vec3 outward = face_normal(patch, x, triangle);
  const bool is_minimum = all_sharing(patch, triangle, at, [&](int other) {
    const double d = closest(patch, x, other, centre).distance_sq;
    outward += face_normal(patch, x, other);
    return d > at.distance_sq + tie || (d >= at.distance_sq - tie && other > triangle);
  });
  if (!is_minimum) return std::nullopt;
  return make_sphere_contact(patch, x, centre, radius, triangle, at, outward);
}

std::optional<Contact> make_sphere_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& centre,
                                           double radius, int triangle, const ClosestPoint& at,
                                           const Vec3& outward) noexcept {
  const Vec3 offset = centre - at.point;
  const double distance = std::sqrt(at.distance_sq);
  if (offset.dot(outward) <= 0) return std::nullopt;  // the far side of the body, seen through it
  Contact contact{triangle, at.bary, Vec3(offset / distance), distance - radius, 0, centre};
  if (patch.is_curved) contact.normal = smoothed(contact.normal, blended_normal(patch, x, triangle, at.bary));
  return contact;
}

namespace {

/// The whole ball about p is behind the triangle's plane. One that rolls over an edge never is, within its radius.
bool is_behind(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& p, double radius) noexcept {
  return face_normal(patch, x, triangle).dot(p - node(x, patch.triangles[triangle][0])) < -radius;
}

}  // namespace

void find_sphere_contacts(const SurfacePatch& patch, const VectorX& x, const Vec3& centre, double radius, double margin,
                          std::span<const int> candidates, int start, ContactSet& out, const Vec3& way,
                          double overlap) noexcept {
  out.count = 0;
  const auto contact_at = [&](int t) -> std::optional<Contact> {
    if (start >= 0 && is_behind(patch, x, t, centre - way, radius)) return std::nullopt;
    return find_sphere_contact(patch, x, centre, radius, margin, t);
  };
  for (const int t : candidates) {
    const auto contact = contact_at(t);
    if (contact && out.count == kMaxContacts) {
      choose_apart(patch, x, radius, candidates, std::cref(contact_at), out);  // by reference: no allocation
      break;
    }
    if (contact) out.contacts[out.count++] = *contact;
  }
  // In an order that does not depend on how triangles are numbered: a law that sweeps over them depends on it.
  std::sort(out.contacts.begin(), out.contacts.begin() + out.count, [](const Contact& a, const Contact& b) {
    return std::lexicographical_compare(a.normal.data(), a.normal.data() + 3, b.normal.data(), b.normal.data() + 3);
  });
  if (out.count > 0 || start < 0) return;
  // Nothing in front of the centre: it may have gone through the surface where it touched before.
  Contact inside = track_point_contact(patch, x, centre, start);
  constexpr double kOn = 1e-9;  // of the radius: a centre on the surface is on neither side, but for rounding
  if (inside.gap <= kOn * radius && inside.gap > -2 * (radius + margin) - way.norm() - overlap) {
    inside.gap -= radius;
    out.add(inside);
  }
}

std::optional<Contact> same_contact(const SurfacePatch& patch, const VectorX& x, const Contact& contact,
                                    double radius) noexcept {
  constexpr double kTurned = 0.5;  // cosine
  Vec3 offset = contact.core;
  for (int c = 0; c < 3; ++c) offset -= contact.bary[c] * node(x, patch.triangles[contact.triangle][c]);
  const double distance = offset.norm();
  if (!(offset.dot(contact.normal) > kTurned * distance)) return std::nullopt;
  Contact out = contact;
  out.normal = offset / distance;
  out.gap = distance - radius;
  if (patch.is_curved) out.normal = smoothed(out.normal, blended_normal(patch, x, contact.triangle, contact.bary));
  return out;
}

}  // namespace kt
