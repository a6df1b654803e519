#pragma once
// The first time at which all conditions of contact may hold: the polynomials of four_points.hpp, each skipped ahead to
// the next time at which its condition is not certainly violated, until none is. Motion: RoundedMotion or ExactMotion.
#include <algorithm>
#include <cmath>
#include <optional>

#include "collision/impact/four_points.hpp"

namespace kt::touch_times {

using bernstein::Cubic;
using bernstein::kNever;

constexpr int kMaxSkips = 64;  // each leads to a root of one of some 40 polynomials, rarely more than three are needed

constexpr double kDecisive = 0x1p20;

/// The areas in the coordinate plane `axis`, in which the normal is largest, and their values at time s.
struct Areas {
  Cubic c[4];
  double now[4];
  int num = 0;
  int axis = -1;
  double normal = 0;         ///< its component
  bool is_regular = false;   ///< which is certainly not zero
  bool is_decisive = false;  ///< and so large that the areas tell inside from outside
};

struct Candidate {
  double s = kNever;  ///< no contact before it; kNever: none at all
  bool is_exhausted = false;
  Areas areas;
};

template <class Motion>
void find_areas(const Motion& m, double s, Areas& out) noexcept {
  int axis = 0;
  double largest = -1;
  for (int k = 0; k < 3; ++k) {
    const NormalComponent n = m.normal(k);
    const double now = n.value(s);
    if (!(std::abs(now) > largest)) continue;
    largest = std::abs(now);
    axis = k;
    out.normal = now;
    out.is_regular = largest > n.error;
    out.is_decisive = largest > kDecisive * n.error;
  }
  if (axis != out.axis) out.num = m.inside(axis, out.c);
  out.axis = axis;
  for (int i = 0; i < out.num; ++i) out.now[i] = value(out.c[i], s);
}

/// Next time at which the areas, which have the values `now`, may all be >= 0, or all <= 0.
inline double next_inside(const Cubic (&area)[4], const double (&now)[4], int n, double from) noexcept {
  bool may_be_positive = true, may_be_negative = true;
  for (int i = 0; i < n; ++i) {
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

/// All conditions but that of distance and of plane `axis`.
template <class Motion>
double next_of_the_others(const Motion& m, int axis, double s) noexcept {
  Cubic c[4];
  double now[4], next = s;
  for (int k = 0; k < 3; ++k) {
    next = std::max(next, next_overlap(c, m.gaps(k, c), s));
    if (k == axis) continue;
    const int n = m.inside(k, c);
    for (int i = 0; i < n; ++i) now[i] = value(c[i], s);
    next = std::max(next, next_inside(c, now, n, s));
  }
  return next;
}

/// The first candidate from `from` on.
template <class Motion>
void next_candidate(const Motion& m, double from, Candidate& out) noexcept {
  out.areas.axis = -1;
  out.is_exhausted = false;
  double s = from;
  for (int i = 0; i < kMaxSkips; ++i) {
    out.s = next_zero(m.distance(), s);
    if (out.s > 1) return;
    find_areas(m, out.s, out.areas);
    s = next_inside(out.areas.c, out.areas.now, out.areas.num, out.s);
    if (s == out.s && !out.areas.is_decisive) s = next_of_the_others(m, out.areas.axis, s);
    if (s == out.s) return;
  }
  out.s = s;
  out.is_exhausted = s <= 1;
}

/// All areas certainly have the normal's sign, or are zero, from the candidate's time `low` to `high`.
inline bool is_inside(const Areas& a, double low, double high) noexcept {
  const double width = high - low, sign = std::copysign(1.0, a.normal);
  for (int i = 0; i < a.num; ++i) {
    // A quadratic sinks between two times by at most an eighth of its second derivative times their distance squared.
    const double least = a.c[i].error + 2 * width * width * largest_coefficient(a.c[i]);
    if (!(sign * a.now[i] > least && sign * value(a.c[i], high) > least)) return false;
  }
  return true;
}

/// There is contact at the start (end = 0) or end (3) of the interval, where exact coefficients have true signs.
inline bool is_contact_at(const Cubic& distance, const Areas& a, int end) noexcept {
  if (!distance.is_exact || distance.b[end] != 0) return false;
  double sum = 0;  // one or two times the normal
  for (int i = 0; i < a.num; ++i) {
    if (std::copysign(1.0, a.normal) * a.c[i].b[end] < 0) return false;
    sum += std::abs(a.c[i].b[end]);
  }
  return sum > 0;
}

/// A time between the candidate and which there certainly is contact. Nothing when that cannot be said.
template <class Motion>
std::optional<double> certain_until(const Motion& m, const Candidate& c) noexcept {
  const Areas& a = c.areas;
  if (!a.is_regular || c.is_exhausted) return std::nullopt;
  const Cubic& f = m.distance();
  if (c.s == 0 && is_contact_at(f, a, 0)) return 0;
  const std::optional<double> at_end = is_contact_at(f, a, 3) ? std::optional(1.0) : std::nullopt;
  if (f.is_exact && largest_coefficient(f) == 0)
    for (double step = 0x1p-50; c.s + step <= 1; step *= 16) {
      Areas later;
      find_areas(m, c.s + step, later);
      if (later.is_regular && is_inside(later, c.s + step, c.s + step)) return c.s + step;
    }
  const double before = value(f, c.s);
  if (!(std::abs(before) > f.error)) return at_end;
  const double way = (std::abs(before) + 2 * f.error) / std::abs(slope(f, c.s)) + 0x1p-52;
  if (!(way < 1e-3)) return at_end;
  for (double high = c.s + way, step = way; high - c.s < 1e-2; step *= 4, high += step) {
    high = std::min(high, 1.0);
    const double after = value(f, high);
    if ((before > 0 ? -after : after) > f.error) return is_inside(a, c.s, high) ? std::optional(high) : at_end;
    if (high == 1) break;
  }
  return at_end;
}

}  // namespace kt::touch_times
