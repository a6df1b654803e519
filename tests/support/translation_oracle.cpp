#include "tests/support/translation_oracle.hpp"

#include <algorithm>

namespace kt {
namespace {

using namespace quad;
using Feature = TranslationTouch::Feature;

/// The tool's centre starts at `from` and moves by `way`, as the triangle sees it.
struct Path {
  Point vertex[3], from, way, normal;
  explicit Path(const CollisionQuery& q) {
    // Relative to the first vertex at the start: the differences of doubles fit into 113 bits.
    const Point origin = point(q.triangle_t0[0]);
    for (int i = 0; i < 3; ++i) vertex[i] = point(q.triangle_t0[i]) - origin;
    from = point(q.tool_t0) - origin;
    way = point(q.tool_t1) - point(q.triangle_t1[0]) - from;
    normal = cross(vertex[1], vertex[2]);
  }
  Point at(Real t) const { return from + t * way; }
};

Real weight(const Path& p, int i, Point x) {
  const Point n = p.normal;
  return dot(n, cross(p.vertex[(i + 1) % 3] - x, p.vertex[(i + 2) % 3] - x)) / dot(n, n);
}
Real least_weight(const Path& p, Point x) { return std::min({weight(p, 0, x), weight(p, 1, x), weight(p, 2, x)}); }

bool has_area(const Path& p) { return dot(p.normal, p.normal) > 0; }

/// Time at which x . x, for x = from + t way, falls to radius_sq, if it does; it may be outside [0, 1].
std::optional<Real> falls_to(Real radius_sq, Point from, Point way) {
  const Real a = dot(way, way), b = dot(from, way), c = dot(from, from) - radius_sq;
  // The discriminant as |from|^2 |way|^2 - (from . way)^2 cancels; the cross product does not.
  const Point across = cross(from, way);
  const Real d = a * radius_sq - dot(across, across);
  if (!(a > 0) || d < 0 || (b > 0 && c > 0)) return std::nullopt;
  const Real root = square_root(d);
  return b < 0 ? c / (root - b) : -(b + root) / a;
}

struct Nearest {
  Feature feature = Feature::vertex;
  Point foot{};
  Real distance_sq = 0;
};

Nearest nearest(const Path& p, Point x) {
  Nearest best{Feature::vertex, p.vertex[0], dot(x - p.vertex[0], x - p.vertex[0])};
  const auto consider = [&](Feature feature, Point foot) {
    const Real d = dot(x - foot, x - foot);
    if (d < best.distance_sq) best = {feature, foot, d};
  };
  for (int i = 0; i < 3; ++i) {
    const Point a = p.vertex[i], edge = p.vertex[(i + 1) % 3] - a;
    consider(Feature::vertex, a);
    const Real s = dot(x - a, edge), length_sq = dot(edge, edge);
    if (s > 0 && s < length_sq) consider(Feature::edge, a + s / length_sq * edge);
  }
  if (has_area(p) && least_weight(p, x) > 0) {
    const Real nn = dot(p.normal, p.normal), height = dot(p.normal, x);
    // By the foot the distance would cancel where x is near the plane.
    if (height * height / nn < best.distance_sq)
      best = {Feature::face, x - height / nn * p.normal, height * height / nn};
  }
  return best;
}

struct Entry {
  Real t;
  Feature feature;
};

/// When the centre enters the sphere around each vertex, the cylinder around each edge, the slab around the face, where
/// the foot lies on that feature: the earliest is the touch, since all of them together are what is nearer than r.
std::optional<Entry> first_entry(const Path& p, Real r) {
  std::optional<Entry> first;
  const auto consider = [&](Real t, Feature feature) {
    if (t >= 0 && t <= 1 && (!first || t < first->t)) first = Entry{t, feature};
  };
  for (int i = 0; i < 3; ++i) {
    const Point a = p.vertex[i], edge = p.vertex[(i + 1) % 3] - a;
    if (const auto t = falls_to(r * r, p.from - a, p.way)) consider(*t, Feature::vertex);
    const Real length_sq = dot(edge, edge);
    if (!(length_sq > 0)) continue;
    const auto across = [&](Point x) { return x - dot(x, edge) / length_sq * edge; };
    const auto t = falls_to(r * r, across(p.from - a), across(p.way));
    if (!t) continue;
    const Real s = dot(p.at(*t) - a, edge);
    if (s >= 0 && s <= length_sq) consider(*t, Feature::edge);
  }
  if (has_area(p)) {
    const Real length = square_root(dot(p.normal, p.normal));
    const Real start = dot(p.normal, p.from) / length, speed = dot(p.normal, p.way) / length;
    const Real t = speed != 0 ? ((speed < 0 ? r : -r) - start) / speed : Real(-1);
    if (t >= 0 && t <= 1 && least_weight(p, p.at(t)) >= 0) consider(t, Feature::face);
  }
  return first;
}

}  // namespace

bool is_translation(const CollisionQuery& q) {
  const auto change = [&](int i) { return point(q.triangle_t1[i]) - point(q.triangle_t0[i]); };
  for (int i = 1; i < 3; ++i) {
    const Point d = change(i) - change(0);
    if (d.x != 0 || d.y != 0 || d.z != 0) return false;
  }
  return true;
}

std::optional<TranslationTouch> first_translation_touch(const CollisionQuery& q, double radius) {
  const Path p(q);
  TranslationTouch out;
  const Nearest start = nearest(p, p.from);
  out.touches_t0 = start.distance_sq <= Real(radius) * radius;
  if (out.touches_t0) {
    out.feature = start.feature;
  } else {
    const auto entry = first_entry(p, radius);
    if (!entry) return std::nullopt;
    out.toi = entry->t;
    out.feature = entry->feature;
  }
  const Point x = p.at(out.toi);
  const Real speed = square_root(dot(p.way, p.way)), length = square_root(dot(p.normal, p.normal));
  const Real along_normal = dot(p.normal, p.way);
  // Where a point touches its distance has no direction: the face's normal is the way.
  if (radius > 0) {
    const Point to_foot = nearest(p, x).foot - x;
    out.closing = static_cast<double>(dot(to_foot, p.way) / (square_root(dot(to_foot, to_foot)) * speed));
    out.from_behind = dot(p.normal, x) < 0;
  } else if (length > 0) {
    out.closing = static_cast<double>(absolute(along_normal) / (length * speed));
    out.from_behind = along_normal > 0;
  }
  if (out.feature != Feature::face && has_area(p)) out.beside_face = static_cast<double>(-least_weight(p, x));
  return out;
}

double translation_gap(const CollisionQuery& q, double radius, Real t) {
  const Path p(q);
  return static_cast<double>(square_root(nearest(p, p.at(t)).distance_sq) - radius);
}

}  // namespace kt
