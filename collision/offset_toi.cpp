// The features come within the distance r when two of their parts do: vertices, a vertex and the inside of an edge, or
// both insides. Each is a set of signs of polynomials; the search skips ahead as that of contact_search.hpp does.
#include "collision/offset_toi.hpp"

#include <span>

#include "collision/polynomial.hpp"
#include "collision/toi.hpp"

namespace kt {
namespace {

using bernstein::kNever;
using bernstein::kRoundoff;
using bernstein::Polynomial;
using Status = OffsetToi::Status;

constexpr int kMaxSkips = 64;

struct Vector {
  Polynomial x[3];
};
Polynomial dot(const Vector& a, const Vector& b) noexcept {
  return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2];
}
Vector cross(const Vector& a, const Vector& b) noexcept {
  return {a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]};
}

/// The earliest time found, and whether the search for it came to its end.
struct First {
  double time = kNever;
  bool is_exhausted = false;
  void take(const First& other) noexcept {
    if (other.time < time) *this = other;
  }
};

using Points = std::span<const int>;

class OffsetSearch {
 public:
  OffsetSearch(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept
      : x_t0_(x_t0), x_t1_(x_t1), distance_(distance * (1 + 4 * kRoundoff)), distance_sq_(distance_ * distance_) {}

  First vertices(int i, int j) const noexcept {
    const Vector d = between(i, j);
    const Polynomial conditions[] = {dot(d, d) - bernstein::line(distance_sq_, distance_sq_, kRoundoff * distance_sq_)};
    const int a[] = {i}, b[] = {j};
    return first(conditions, a, b);
  }

  /// Point i and the inside of the edge from j to k.
  First vertex_edge(int i, int j, int k) const noexcept {
    const Vector e = between(k, j), d = between(i, j), c = cross(e, d);
    const Polynomial ee = dot(e, e), de = dot(d, e);
    const Polynomial conditions[] = {dot(c, c) - distance_sq_ * ee, -1 * de, de - ee, beyond(dot(d, d), unit(), ee)};
    const int a[] = {i}, b[] = {j, k};
    return first(conditions, a, b);
  }

  /// Point 0 and the inside of the face.
  First face() const noexcept {
    const Vector e1 = between(2, 1), e2 = between(3, 1), d = between(0, 1), n = cross(e1, e2);
    const Polynomial nn = dot(n, n), volume = dot(n, d), beta = dot(n, cross(d, e2)), gamma = dot(n, cross(e1, d));
    const Vector c1 = cross(d, e1), c2 = cross(d, e2);
    const Polynomial conditions[] = {volume * volume - distance_sq_ * nn,
                                     -1 * beta,
                                     -1 * gamma,
                                     beta + gamma - nn,
                                     beyond(dot(c1, c1), dot(e1, e1), nn),
                                     beyond(dot(c2, c2), dot(e2, e2), nn)};
    const Polynomial ee = dot(e1, e2), de1 = dot(d, e1), de2 = dot(d, e2);
    const Polynomial along[2][4] = {{de1, de1 - dot(e1, e1), de1 - ee, de1}, {de2, de2 - dot(e2, e2), de2 - ee, de2}};
    const int a[] = {0}, b[] = {1, 2, 3};
    return first(conditions, a, b, along);
  }

  /// The insides of both edges.
  First edges() const noexcept {
    const Vector e1 = between(1, 0), e2 = between(3, 2), d = between(2, 0), n = cross(e1, e2);
    const Vector c1 = cross(d, e1), c2 = cross(d, e2);
    const Polynomial nn = dot(n, n), volume = dot(n, d), s = dot(n, c2), r = dot(n, c1);
    const Polynomial conditions[] = {
        volume * volume - distance_sq_ * nn, -1 * s, s - nn, -1 * r, r - nn, beyond(dot(c1, c1), dot(e1, e1), nn),
        beyond(dot(c2, c2), dot(e2, e2), nn)};
    const Polynomial e11 = dot(e1, e1), e22 = dot(e2, e2), ee = dot(e1, e2), de1 = dot(d, e1), de2 = dot(d, e2);
    const Polynomial along[2][4] = {{de1, de1 + ee, de1 - e11, de1 + ee - e11},
                                    {de2, de2 + e22, de2 - ee, de2 + e22 - ee}};
    const int a[] = {0, 1}, b[] = {2, 3};
    return first(conditions, a, b, along);
  }

 private:
  /// Component k of the way from point j to point i.
  Polynomial difference(int i, int j, int k) const noexcept {
    const double a = x_t0_[i][k] - x_t0_[j][k], b = x_t1_[i][k] - x_t1_[j][k];
    return bernstein::line(a, b, kRoundoff * std::max(std::abs(a), std::abs(b)));
  }
  static Polynomial unit() noexcept { return bernstein::line(1, 1, 0); }

  /// Positive only where |x| > r |y| + |z|, for the squares of the three: since (a + b)^2 <= (1 + k) a^2 + (1 + 1/k)
  /// b^2. The other conditions say nothing where an edge vanishes or two are parallel (z = 0): there this one does.
  Polynomial beyond(const Polynomial& x_sq, const Polynomial& y_sq, const Polynomial& z_sq) const noexcept {
    constexpr double k = 0x1p-20;
    return x_sq - (1 + k) * distance_sq_ * y_sq - (1 + 1 / k) * z_sq;
  }
  Vector between(int i, int j) const noexcept {
    return {{difference(i, j, 0), difference(i, j, 1), difference(i, j, 2)}};
  }

  /// Next time at which, on every axis, the intervals of both sets of points come within the distance.
  double next_overlap(Points a, Points b, double from) const noexcept {
    const Polynomial r = bernstein::line(distance_, distance_, 0);
    double next = from;
    for (int k = 0; k < 3; ++k) {
      double above = kNever, below = kNever;  // when a gap on that side ends
      for (const int i : a)
        for (const int j : b) {
          above = std::min(above, next_nonpositive(difference(i, j, k) - r, from));
          below = std::min(below, next_nonpositive(difference(j, i, k) - r, from));
        }
      next = std::max(next, std::max(above, below));
    }
    return next;
  }

  /// Next time at which not all four have one sign.
  static double next_mixed(const Polynomial (&p)[4], double from) noexcept {
    double positive = kNever, negative = kNever;
    for (const Polynomial& x : p) {
      positive = std::min(positive, next_nonpositive(x, from));
      negative = std::min(negative, next_nonpositive(-1 * x, from));
    }
    return std::max(positive, negative);
  }

  using Along = std::span<const Polynomial[4]>;

  /// First time at which no condition, all of which are "<= 0", is certainly violated. along: the shortest way between
  /// the insides of two features is across their edges, so on these both cover a common place.
  First first(std::span<const Polynomial> conditions, Points a, Points b, Along along = {}) const noexcept {
    double s = 0;
    for (int skip = 0; skip < kMaxSkips; ++skip) {
      const double from = s;
      for (const Polynomial& p : conditions) {
        s = next_nonpositive(p, s);
        if (s > 1) return {};
      }
      if (s > from) continue;
      s = next_overlap(a, b, s);
      for (const auto& p : along) s = std::max(s, next_mixed(p, from));
      if (s > 1) return {};
      if (s == from) return {s, false};
    }
    return {s, true};
  }

  const Vec3 (&x_t0_)[4];
  const Vec3 (&x_t1_)[4];
  double distance_, distance_sq_;  // rounded up
};

bool is_valid(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept {
  double largest = distance;
  bool is_in_range = distance >= 0;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k)
      for (const double x : {x_t0[i][k], x_t1[i][k]}) {
        is_in_range = is_in_range && std::abs(x) <= kLargestCoordinate;  // false for NaN
        largest = std::max(largest, std::abs(x));
      }
  return is_in_range && largest <= kLargestCoordinate && (largest == 0 || largest >= kSmallestExtent);
}

OffsetToi result(const First& first) noexcept {
  if (first.time > 1) return {};
  if (first.is_exhausted) return {Status::budget_exhausted, first.time};
  return {first.time == 0 ? Status::already_inside : Status::hit, first.time};
}

}  // namespace

OffsetToi vertex_face_offset_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept {
  if (!is_valid(x_t0, x_t1, distance)) return {Status::invalid_input, 1};
  const OffsetSearch search(x_t0, x_t1, distance);
  First first = search.face();
  for (int i = 1; i < 4; ++i) {
    first.take(search.vertices(0, i));
    first.take(search.vertex_edge(0, i, i % 3 + 1));
  }
  return result(first);
}

OffsetToi edge_edge_offset_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept {
  if (!is_valid(x_t0, x_t1, distance)) return {Status::invalid_input, 1};
  const OffsetSearch search(x_t0, x_t1, distance);
  First first = search.edges();
  for (int a = 0; a < 2; ++a) {
    first.take(search.vertex_edge(a, 2, 3));
    first.take(search.vertex_edge(a + 2, 0, 1));
    for (int b = 2; b < 4; ++b) first.take(search.vertices(a, b));
  }
  return result(first);
}

}  // namespace kt
