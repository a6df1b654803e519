#pragma once
// The first time at which all conditions of contact may hold: the polynomials of four_points.hpp, each skipped ahead to
// the next time at which its condition is not certainly violated, until none is. Motion: RoundedMotion or ExactMotion.
#include <algorithm>
#include <cmath>
#include <optional>

#include "collision/four_points.hpp"

namespace kt::contact_search {

using bernstein::Cubic;
using bernstein::kNever;

constexpr int kMaxSkips = 64;  // each leads to a root of one of some 40 polynomials, rarely more than three are needed

struct Candidate {
  double s = kNever;       ///< no contact before it; kNever: none at all
  int axis = 0;            ///< coordinate plane in which the areas are largest
  bool is_regular = true;  ///< the normal is certainly not zero
  bool is_exhausted = false;
};

/// Next time at which the areas may all be >= 0, or all <= 0.
inline double next_inside(const Cubic (&area)[4], int n, double from) noexcept {
  double now[4];
  bool may_be_positive = true, may_be_negative = true;
  for (int i = 0; i < n; ++i) {
    now[i] = from == 0 ? area[i].b[0] : value(area[i], from);
    may_be_positive = may_be_positive && now[i] >= -2 * area[i].error;
    may_be_negative = may_be_negative && now[i] <= 2 * area[i].error;
  }
  if (may_be_positive || may_be_negative) return from;
  double positive = from, negative = from;
  for (int i = 0; i < n; ++i) {
    if (now[i] < -2 * area[i].error) positive = std::max(positive, next_nonpositive(negated(area[i]), from));
    if (now[i] > 2 * area[i].error) negative = std::max(negative, next_nonpositive(area[i], from));
  }
  return std::min(positive, negative);
}

/// Next time at which the differences may not all have one sign.
inline double next_overlap(const Cubic (&gap)[4], int n, double from) noexcept {
  double positive = kNever, negative = kNever;  // when a gap of that sign ends
  for (int i = 0; i < n; ++i) {
    positive = std::min(positive, next_nonpositive(gap[i], from));
    negative = std::min(negative, next_nonpositive(negated(gap[i]), from));
  }
  return std::max(positive, negative);
}

template <class Motion>
int largest_normal_component(const Motion& m, double s, bool& is_certain) noexcept {
  int axis = 0;
  double largest = -1;
  is_certain = false;
  for (int k = 0; k < 3; ++k) {
    const NormalComponent n = m.normal(k);
    const double size = std::abs(n.value(s));
    if (!(size > largest)) continue;
    largest = size;
    axis = k;
    is_certain = size > n.error;
  }
  return axis;
}

/// All conditions but that of distance and of plane `axis`.
template <class Motion>
double next_of_the_others(const Motion& m, int axis, double s) noexcept {
  Cubic c[4];
  double next = s;
  for (int k = 0; k < 3; ++k) {
    next = std::max(next, next_overlap(c, m.gaps(k, c), s));
    if (k != axis) next = std::max(next, next_inside(c, m.inside(k, c), s));
  }
  return next;
}

template <class Motion>
Candidate next_candidate(const Motion& m, double from) noexcept {
  Candidate out;
  Cubic area[4];
  int num_areas = 0, loaded = -1;
  double s = from;
  for (int i = 0; i < kMaxSkips; ++i) {
    s = next_zero(m.distance(), s);
    if (s > 1) return {};
    out.axis = largest_normal_component(m, s, out.is_regular);
    if (out.axis != loaded) num_areas = m.inside(out.axis, area);
    loaded = out.axis;
    out.s = s;
    s = next_inside(area, num_areas, s);
    if (s > 1) return {};
    if (s > out.s) continue;
    if (!out.is_regular) s = next_of_the_others(m, out.axis, s);
    if (s > 1) return {};
    if (s == out.s) return out;
  }
  out.s = s;
  out.is_exhausted = true;
  return out;
}

/// All areas are certainly of the sign `sign`, or zero, on all of [low, high].
inline bool is_inside(const Cubic (&area)[4], int n, double sign, double low, double high) noexcept {
  const double width = high - low;
  for (int i = 0; i < n; ++i) {
    // A quadratic sinks between two times by at most an eighth of its second derivative times their distance squared.
    const double least = area[i].error + 2 * width * width * largest_coefficient(area[i]);
    for (const double s : {low, high}) {
      if (sign * value(area[i], s) > least) continue;
      const bool is_exact = width == 0 && area[i].is_exact && (s == 0 || s == 1);
      if (!is_exact || sign * (s == 0 ? area[i].b[0] : area[i].b[3]) < 0) return false;
    }
  }
  return true;
}

/// A time between the candidate and which there certainly is contact. Nothing when that cannot be said.
template <class Motion>
std::optional<double> certain_until(const Motion& m, const Candidate& c) noexcept {
  if (!c.is_regular) return std::nullopt;
  const Cubic& f = m.distance();
  Cubic area[4];
  const int n = m.inside(c.axis, area);
  const double sign = m.normal(c.axis).value(c.s);
  if (f.is_exact) {
    if ((c.s == 0 && f.b[0] == 0) || (c.s == 1 && f.b[3] == 0))
      if (is_inside(area, n, sign, c.s, c.s)) return c.s;
    if (largest_coefficient(f) == 0)
      for (double high = c.s; high <= 1; high += high == c.s ? 0x1p-50 : 16 * (high - c.s))
        if (is_inside(area, n, sign, high, high)) return high;
  }
  const double before = value(f, c.s);
  if (!(std::abs(before) > f.error)) return std::nullopt;
  const double way = (std::abs(before) + 2 * f.error) / std::abs(slope(f, c.s)) + 0x1p-52;
  if (!(way < 1e-3)) return std::nullopt;
  for (double high = c.s + way, step = way; high - c.s < 1e-2; step *= 4, high += step) {
    high = std::min(high, 1.0);
    const double after = value(f, high);
    if ((before > 0 ? -after : after) > f.error)
      return is_inside(area, n, sign, c.s, high) ? std::optional(high) : std::nullopt;
    if (high == 1) break;
  }
  return std::nullopt;
}

}  // namespace kt::contact_search
