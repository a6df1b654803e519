#include "tests/support/toi_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/quad_point.hpp"

namespace kt {
namespace {

using namespace quad;
constexpr double kZero = kIsLong ? 1e-20 : 1e-9;  // of a distance: a root is known to 1e-28 at least

Point at(const IntegerMotion& x, int i, Real t) {
  const auto lerp = [&](int k) { return x.t0[i][k] + t * (x.t1[i][k] - x.t0[i][k]); };
  return {lerp(0), lerp(1), lerp(2)};
}

/// p[0] + p[1] t + p[2] t^2 + p[3] t^3 with the values v at t = 0, 1, 2, 3, which are integers: exact.
using Polynomial = std::vector<Real>;
Polynomial interpolate(const Real (&v)[4]) {
  const Real d1 = v[1] - v[0], d2 = v[2] - 2 * v[1] + v[0], d3 = v[3] - 3 * v[2] + 3 * v[1] - v[0];
  return {v[0], d1 - d2 / 2 + d3 / 3, d2 / 2 - d3 / 2, d3 / 6};
}
template <class F>
Polynomial polynomial_of(F&& f) {
  const Real v[4] = {f(0), f(1), f(2), f(3)};
  return interpolate(v);
}
Real value(const Polynomial& p, Real t) { return p[0] + t * (p[1] + t * (p[2] + t * p[3])); }
bool is_zero(const Polynomial& p) {
  for (Real c : p)
    if (absolute(c) > Real(1e-12)) return false;  // coefficients are sixths of integers
  return true;
}

/// Roots in [0, 1], touching ones included.
void append_roots(const Polynomial& p, std::vector<Real>& out) {
  if (is_zero(p)) return;
  std::vector<Real> ends{0, 1};
  const Real a = 3 * p[3], b = 2 * p[2], c = p[1];
  Real d = b * b - 4 * a * c;
  if (absolute(d) < Real(1e-12)) d = 0;
  if (d >= 0) {
    const Real h = -(b + (b < 0 ? -square_root(d) : square_root(d))) / 2;
    if (absolute(a) > Real(1e-12)) ends.push_back(h / a);
    if (absolute(h) > Real(1e-12)) ends.push_back(c / h);
    if (absolute(a) > Real(1e-12) && d == 0) ends.push_back(-b / (2 * a));
  }
  std::erase_if(ends, [](Real t) { return !(t >= 0 && t <= 1); });
  std::sort(ends.begin(), ends.end());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (absolute(value(p, ends[i])) < Real(1e-24)) out.push_back(ends[i]);
    if (i + 1 == ends.size()) break;
    Real low = ends[i], high = ends[i + 1];
    const bool rises = value(p, low) < 0;
    if (rises == (value(p, high) < 0)) continue;
    for (int k = 0; k < 112; ++k) {
      const Real middle = (low + high) / 2;
      ((value(p, middle) < 0) == rises ? low : high) = middle;
    }
    out.push_back(low);
  }
}

Real distance_sq(Point p, Point a, Point b) {
  const Real length_sq = dot(b - a, b - a);
  const Real s = length_sq > 0 ? clamp(dot(p - a, b - a) / length_sq) : 0;
  const Point d = p - (a + s * (b - a));
  return dot(d, d);
}

Real face_distance_sq(const Point (&x)[4]) {
  Real best = std::min({distance_sq(x[0], x[1], x[2]), distance_sq(x[0], x[2], x[3]), distance_sq(x[0], x[3], x[1])});
  const Point n = cross(x[2] - x[1], x[3] - x[1]);
  const Real nn = dot(n, n);
  if (!(nn > Real(kZero))) return best;
  for (int i = 0; i < 3; ++i)
    if (dot(n, cross(x[1 + (i + 1) % 3] - x[0], x[1 + (i + 2) % 3] - x[0])) < 0) return best;
  const Real height = dot(n, x[0] - x[1]);
  return std::min(best, height * height / nn);
}

Real edge_distance_sq(const Point (&x)[4]) {
  Real best = std::min({distance_sq(x[0], x[2], x[3]), distance_sq(x[1], x[2], x[3]), distance_sq(x[2], x[0], x[1]),
                        distance_sq(x[3], x[0], x[1])});
  const Point a = x[1] - x[0], b = x[3] - x[2], d = x[2] - x[0], n = cross(a, b);
  const Real nn = dot(n, n);
  if (!(nn > Real(kZero))) return best;
  const Real s = dot(n, cross(d, b)) / nn, r = dot(n, cross(d, a)) / nn;
  if (s < 0 || s > 1 || r < 0 || r > 1) return best;
  const Real height = dot(n, d);
  return std::min(best, height * height / nn);
}

/// Every time at which contact can begin. Where the four points stay in one plane that is any at which three of them
/// are in line in a coordinate plane, or two have one coordinate.
std::vector<Real> candidates(const IntegerMotion& x) {
  std::vector<Real> out{0};
  const auto place = [&](int i, Real t) { return at(x, i, t); };
  const Polynomial volume = polynomial_of([&](Real t) {
    return dot(cross(place(1, t) - place(0, t), place(2, t) - place(0, t)), place(3, t) - place(0, t));
  });
  append_roots(volume, out);
  if (!is_zero(volume)) return out;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        append_roots(polynomial_of([&](Real t) { return component(place(i, t) - place(j, t), k); }), out);
        for (int l = j + 1; l < 4; ++l)
          append_roots(polynomial_of([&](Real t) {
                         return component(cross(place(j, t) - place(i, t), place(l, t) - place(i, t)), k);
                       }),
                       out);
      }
  return out;
}

template <class DistanceSq>
std::optional<double> first_contact(const IntegerMotion& x, DistanceSq distance_sq_of) {
  std::vector<Real> times = candidates(x);
  std::sort(times.begin(), times.end());
  for (const Real t : times) {
    const Point now[4] = {at(x, 0, t), at(x, 1, t), at(x, 2, t), at(x, 3, t)};
    if (distance_sq_of(now) < Real(kZero) * Real(kZero)) return static_cast<double>(t);
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> first_contact_of_vertex_face(const IntegerMotion& x) {
  return first_contact(x, [](const Point(&p)[4]) { return face_distance_sq(p); });
}
std::optional<double> first_contact_of_edges(const IntegerMotion& x) {
  return first_contact(x, [](const Point(&p)[4]) { return edge_distance_sq(p); });
}

double feature_distance(bool is_face, const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double t) {
  Point now[4];
  for (int i = 0; i < 4; ++i) {
    const auto lerp = [&](int k) { return Real(x_t0[i][k]) + Real(t) * (Real(x_t1[i][k]) - Real(x_t0[i][k])); };
    now[i] = {lerp(0), lerp(1), lerp(2)};
  }
  return static_cast<double>(square_root(is_face ? face_distance_sq(now) : edge_distance_sq(now)));
}

}  // namespace kt
