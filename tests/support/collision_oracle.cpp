#include "tests/support/collision_oracle.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/quad_point.hpp"

namespace kt {
namespace {

using namespace quad;

Real distance_sq_to_segment(Point p, Point a, Point b) {
  const Real length_sq = dot(b - a, b - a);
  Real s = length_sq > 0 ? dot(p - a, b - a) / length_sq : 0;
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  const Point d = p - (a + s * (b - a));
  return dot(d, d);
}

/// Weights of p's foot in the plane, with the normal that they were found with.
struct Foot {
  Real weight[3], distance_sq;
};
std::optional<Foot> foot_in_plane(Point p, const Point (&v)[3]) {
  const Point n = cross(v[1] - v[0], v[2] - v[0]);
  const Real nn = dot(n, n);
  if (!(nn > 0)) return std::nullopt;
  Foot out;
  for (int i = 0; i < 3; ++i) out.weight[i] = dot(n, cross(v[(i + 1) % 3] - p, v[(i + 2) % 3] - p)) / nn;
  const Real height = dot(n, p - v[0]);
  out.distance_sq = height * height / nn;
  return out;
}

Real distance_sq(Point p, const Point (&v)[3]) {
  Real best = distance_sq_to_segment(p, v[0], v[1]);
  best = std::min(best, distance_sq_to_segment(p, v[1], v[2]));
  best = std::min(best, distance_sq_to_segment(p, v[2], v[0]));
  if (const auto foot = foot_in_plane(p, v))
    if (foot->weight[0] >= 0 && foot->weight[1] >= 0 && foot->weight[2] >= 0) best = std::min(best, foot->distance_sq);
  return best;
}

/// Triangle relative to the tool, unrounded.
struct Motion {
  Point at_t0[3], change[3];
  explicit Motion(const CollisionQuery& q) {
    for (int i = 0; i < 3; ++i) {
      at_t0[i] = point(q.triangle_t0[i]) - point(q.tool_t0);
      change[i] = point(q.triangle_t1[i]) - point(q.tool_t1) - at_t0[i];
    }
  }
  void place(Real t, Point (&out)[3]) const {
    for (int i = 0; i < 3; ++i) out[i] = at_t0[i] + t * change[i];
  }
  Real distance(Real t) const {
    Point now[3];
    place(t, now);
    return square_root(distance_sq({0, 0, 0}, now));
  }
};

/// Coefficients of side(t) = n(t) . (tool - a(t)): positive outside.
std::array<Real, 4> side_polynomial(const Motion& m) {
  const Point b0 = m.at_t0[1] - m.at_t0[0], b1 = m.change[1] - m.change[0];
  const Point c0 = m.at_t0[2] - m.at_t0[0], c1 = m.change[2] - m.change[0];
  const Point n0 = cross(b0, c0), n1 = cross(b0, c1) + cross(b1, c0), n2 = cross(b1, c1);
  const Point a0 = m.at_t0[0], a1 = m.change[0];
  return {-dot(n0, a0), -dot(n0, a1) - dot(n1, a0), -dot(n1, a1) - dot(n2, a0), -dot(n2, a1)};
}

Real value(const std::array<Real, 4>& p, Real t) { return p[0] + t * (p[1] + t * (p[2] + t * p[3])); }

/// 0, the turning points inside (0, 1), and 1.
std::vector<Real> monotone_pieces(const std::array<Real, 4>& p) {
  std::vector<Real> ends{0};
  const Real a = 3 * p[3], b = 2 * p[2], c = p[1], d = b * b - 4 * a * c;
  if (d >= 0) {
    const Real h = -(b + (b < 0 ? -square_root(d) : square_root(d))) / 2;
    if (a != 0) ends.push_back(h / a);
    if (h != 0) ends.push_back(c / h);
  }
  std::erase_if(ends, [](Real t) { return !(t >= 0 && t < 1); });
  ends.push_back(1);
  std::sort(ends.begin(), ends.end());
  return ends;
}

}  // namespace

CollisionQuery reversed(const CollisionQuery& q) {
  return {q.tool_t0,
          {q.triangle_t0[0], q.triangle_t0[2], q.triangle_t0[1]},
          q.tool_t1,
          {q.triangle_t1[0], q.triangle_t1[2], q.triangle_t1[1]}};
}

double exact_distance(const Vec3& p, const Vec3 (&triangle)[3]) {
  const Point v[3] = {point(triangle[0]), point(triangle[1]), point(triangle[2])};
  return static_cast<double>(square_root(distance_sq(point(p), v)));
}

double exact_distance(const CollisionQuery& q, double t) { return static_cast<double>(Motion(q).distance(t)); }

std::optional<ExactImpact> exact_point_impact(const CollisionQuery& q) {
  const Motion m(q);
  const auto side = side_polynomial(m);
  const std::vector<Real> ends = monotone_pieces(side);
  Real scale = 0;
  for (Real c : side) scale = std::max(scale, absolute(c));
  constexpr double kTooNear = 1e-9;  // of the step, of the weights, of the largest volume
  ExactImpact out;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    Real low = ends[i], high = ends[i + 1];
    const Real at_low = value(side, low), at_high = value(side, high);
    if (absolute(at_low) < kTooNear * scale || absolute(at_high) < kTooNear * scale) out.ambiguous = true;
    if (!(at_low > 0 && at_high <= 0)) continue;
    for (int k = 0; k < 112; ++k) {
      const Real middle = (low + high) / 2;
      (value(side, middle) > 0 ? low : high) = middle;
    }
    Point now[3];
    m.place(low, now);
    const auto foot = foot_in_plane({0, 0, 0}, now);
    if (!foot) continue;
    const Real least = std::min({foot->weight[0], foot->weight[1], foot->weight[2]});
    if (absolute(least) < kTooNear) out.ambiguous = true;
    if (least < 0) continue;
    out.toi = static_cast<double>(low);
    return out;
  }
  if (out.ambiguous) return out;
  return std::nullopt;
}

std::optional<ExactImpact> exact_sphere_impact(const CollisionQuery& q, double radius) {
  const Motion m(q);
  Real speed = 0;
  for (const Point& c : m.change) speed = std::max(speed, square_root(dot(c, c)));
  const auto gap = [&](Real t) { return m.distance(t) - radius; };
  // Every interval that could hold contact (the gap changes by at most the speed) is halved, the earliest first.
  constexpr double kFine = 1e-9;  // of the step: nearer than it moves in this time is a graze, unless contact follows
  std::optional<Real> graze;
  std::vector<std::pair<Real, Real>> open{{0, 1}};
  while (!open.empty()) {
    auto [low, high] = open.back();
    open.pop_back();
    const Real middle = (low + high) / 2;
    if (gap(middle) - speed * (high - low) / 2 > 0) continue;
    if (high - low > kFine) {
      open.push_back({middle, high});
      open.push_back({low, middle});
      continue;
    }
    if (graze && low - *graze > 10 * kFine) break;
    if (!graze) graze = low;
    if (gap(high) > 0) continue;
    for (int k = 0; k < 60; ++k) {
      const Real half = (low + high) / 2;
      (gap(half) > 0 ? low : high) = half;
    }
    return ExactImpact{static_cast<double>(low), false};
  }
  if (graze) return ExactImpact{static_cast<double>(*graze), true};
  return std::nullopt;
}

}  // namespace kt
