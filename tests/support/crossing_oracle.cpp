#include "tests/support/crossing_oracle.hpp"

#include <algorithm>

namespace kt {
namespace {

using namespace quad;

constexpr double kRounding = 1e-31;  // of the largest volume: some dozen operations of 113 bits
constexpr double kGrown = 1e-18;     // of a weight: roots of shallow crossings are less exact than 113 bits

Real length(Point a) { return square_root(dot(a, a)); }

/// Relative to the point: vertex a, and the edges b, c from there, each at + t change.
struct Motion {
  Point a, b, c, a1, b1, c1;
  explicit Motion(const CollisionQuery& q) {
    const auto t0 = [&](int i) { return point(q.triangle_t0[i]); };
    const auto t1 = [&](int i) { return point(q.triangle_t1[i]); };
    a = t0(0) - point(q.tool_t0);
    b = t0(1) - t0(0);
    c = t0(2) - t0(0);
    a1 = t1(0) - point(q.tool_t1) - a;
    b1 = t1(1) - t1(0) - b;
    c1 = t1(2) - t1(0) - c;
  }
  /// The point lies in the triangle at t, when it is in its plane then.
  bool is_inside(Real t) const {
    const Point at = a + t * a1, ab = b + t * b1, ac = c + t * c1, n = cross(ab, ac);
    const Real nn = dot(n, n);
    if (!(nn > kRounding * dot(ab, ab) * dot(ac, ac))) return false;
    const Real to_b = dot(n, cross(ac, at)) / nn, to_c = dot(n, cross(at, ab)) / nn;
    return to_b >= -kGrown && to_c >= -kGrown && 1 - to_b - to_c >= -kGrown;
  }
};

/// Six times the volume of point and triangle: positive in front. And what rounding may have done to it.
struct Side {
  Real p[4], error;
  explicit Side(const Motion& m) {
    const Point n0 = cross(m.b, m.c), n1 = cross(m.b, m.c1) + cross(m.b1, m.c), n2 = cross(m.b1, m.c1);
    p[0] = -dot(n0, m.a);
    p[1] = -dot(n0, m.a1) - dot(n1, m.a);
    p[2] = -dot(n1, m.a1) - dot(n2, m.a);
    p[3] = -dot(n2, m.a1);
    error = kRounding * (length(m.a) + length(m.a1)) * (length(m.b) + length(m.b1)) * (length(m.c) + length(m.c1));
  }
  Real operator()(Real t) const { return p[0] + t * (p[1] + t * (p[2] + t * p[3])); }

  /// 0, the turning points in between, and 1; returns how many.
  int monotone_pieces(Real (&ends)[4]) const {
    int count = 0;
    ends[count++] = 0;
    const auto add = [&](Real t) {
      if (t > 0 && t < 1) ends[count++] = t;
    };
    const Real a = 3 * p[3], b = 2 * p[2], c = p[1], d = b * b - 4 * a * c;
    if (d >= 0) {
      const Real h = -(b + (b < 0 ? -square_root(d) : square_root(d))) / 2;
      if (a != 0) add(h / a);
      if (h != 0) add(c / h);
    }
    if (count == 3 && ends[2] < ends[1]) std::swap(ends[1], ends[2]);
    ends[count++] = 1;
    return count;
  }
};

/// Where the side, which falls (or rises) from low to high, has come to zero.
Real root(const Side& side, Real low, Real high, bool falls) {
  const auto is_before = [&](Real t) { return falls ? side(t) > 0 : side(t) < 0; };
  if (!is_before(low)) return low;
  if (is_before(high)) return high;
  for (int i = 0; i < 112; ++i) {
    const Real middle = (low + high) / 2;
    (is_before(middle) ? low : high) = middle;
  }
  return high;
}

/// A plane along the path keeps all vertices on one side, clear of rounding: no crossing.
bool is_clear(const Vec3 (&relative)[6], const Vec3& way, const Vec3& across) {
  const Vec3 second = way.cross(across);
  constexpr double kHalf = 0.70710678118654752;
  const double length_ratio = across.norm() / second.norm();
  const Vec3 u = across, v = length_ratio * second;
  for (const Vec3& n : {u, v, Vec3(kHalf * (u + v)), Vec3(kHalf * (u - v))}) {
    double low = 1e300, high = -1e300, size = 0;
    for (const Vec3& x : relative) {
      low = std::min(low, n.dot(x));
      high = std::max(high, n.dot(x));
      size = std::max(size, n.norm() * x.norm());
    }
    if (low > 1e-12 * size || high < -1e-12 * size) return true;
  }
  return false;
}

void keep_earlier(std::optional<Real>& first, const std::optional<Real>& t) {
  if (t && (!first || *t < *first)) first = t;
}

}  // namespace

Crossings find_crossings(const CollisionQuery& q) {
  const Motion m(q);
  const Side side(m);
  Real ends[4];
  const int count = side.monotone_pieces(ends);
  Crossings out;
  for (int i = 0; i + 1 < count; ++i) {
    const Real at_low = side(ends[i]), at_high = side(ends[i + 1]);
    const bool falls = at_low > at_high;
    const Real before = falls ? at_low : -at_low, after = falls ? at_high : -at_high;
    if (before < -side.error || after > side.error || before - after <= 4 * side.error) continue;
    const Real t = root(side, ends[i], ends[i + 1], falls);
    if (m.is_inside(t)) keep_earlier(falls ? out.from_front : out.from_behind, t);
  }
  return out;
}

void CrossingOracle::refit(const VectorX& x_t0, const VectorX& x_t1) {
  x_t0_ = &x_t0;
  x_t1_ = &x_t1;
  boxes_.resize(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    Box& box = boxes_[t];
    box.low = box.high = node(x_t0, triangles_[t][0]);
    for (const int v : triangles_[t])
      for (const VectorX* x : {&x_t0, &x_t1}) {
        box.low = box.low.cwiseMin(node(*x, v));
        box.high = box.high.cwiseMax(node(*x, v));
      }
  }
}

CollisionQuery CrossingOracle::query(const ToolSweep& sweep, int triangle) const {
  CollisionQuery q;
  q.tool_t0 = sweep.x_t0;
  q.tool_t1 = sweep.x_t1;
  for (int i = 0; i < 3; ++i) {
    q.triangle_t0[i] = node(*x_t0_, triangles_[triangle][i]);
    q.triangle_t1[i] = node(*x_t1_, triangles_[triangle][i]);
  }
  return q;
}

Crossings CrossingOracle::find(const ToolSweep& sweep, int& triangle) const {
  const Vec3 low = sweep.x_t0.cwiseMin(sweep.x_t1), high = sweep.x_t0.cwiseMax(sweep.x_t1);
  const Vec3 way = sweep.x_t1 - sweep.x_t0, across = way.unitOrthogonal();
  Crossings first;
  for (std::size_t t = 0; t < boxes_.size(); ++t) {
    const Box& box = boxes_[t];
    if (box.low[0] > high[0] || box.high[0] < low[0] || box.low[1] > high[1] || box.high[1] < low[1] ||
        box.low[2] > high[2] || box.high[2] < low[2])
      continue;
    const CollisionQuery q = query(sweep, static_cast<int>(t));
    Vec3 relative[6];
    for (int i = 0; i < 3; ++i) {
      relative[i] = q.triangle_t0[i] - q.tool_t0;
      relative[3 + i] = q.triangle_t1[i] - q.tool_t1;
    }
    if (is_clear(relative, way, across)) continue;
    const Crossings one = find_crossings(q);
    if (one.from_front && (!first.from_front || *one.from_front < *first.from_front)) triangle = static_cast<int>(t);
    keep_earlier(first.from_front, one.from_front);
    keep_earlier(first.from_behind, one.from_behind);
  }
  return first;
}

}  // namespace kt
