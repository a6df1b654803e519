#include "collision/impact/bernstein.hpp"

namespace kt::bernstein {
namespace {

constexpr int kMaxNewton = 60;  // then the bracket is halved to a double's resolution
constexpr double kNearRoot = 0x1p-28;
constexpr int kMaxHalvings = 50;
constexpr int kMaxPieces = 200;  // of one proof: then what is proven so far counts

/// One de Casteljau step: the parts of b before and after s. Each result is off by at most 9 u max |b|: three levels
/// of (1 - s) x + s y, each within 3 u of the larger of |x| and |y|.
void subdivide(const double (&b)[4], double s, double (&left)[4], double (&right)[4]) noexcept {
  const double r = 1 - s;
  const double b01 = r * b[0] + s * b[1], b12 = r * b[1] + s * b[2], b23 = r * b[2] + s * b[3];
  const double b012 = r * b01 + s * b12, b123 = r * b12 + s * b23;
  const double middle = r * b012 + s * b123;
  left[0] = b[0], left[1] = b01, left[2] = b012, left[3] = middle;
  right[0] = middle, right[1] = b123, right[2] = b23, right[3] = b[3];
}

bool all_above(const double (&b)[4], double level) noexcept {
  return std::min(std::min(b[0], b[1]), std::min(b[2], b[3])) > level;
}

/// How much of [0, 1] is proven to have b > level, from 0 on, by halving. Each halving rounds by at most 3 u max |b|,
/// which `rounding` covers.
double proven_above(const double (&b)[4], double level, double rounding, int depth, int& pieces) noexcept {
  if (all_above(b, level)) return 1;
  if (depth == 0 || !(b[0] > level) || --pieces < 0) return 0;
  double left[4], right[4];
  subdivide(b, 0.5, left, right);
  level += rounding;
  const double first = proven_above(left, level, rounding, depth - 1, pieces);
  return first < 1 ? 0.5 * first : 0.5 + 0.5 * proven_above(right, level, rounding, depth - 1, pieces);
}

/// Power form, for the search of a root that is proven afterwards.
struct Power {
  double c0, c1, c2, c3;
  double value(double s) const noexcept { return c0 + s * (c1 + s * (c2 + s * c3)); }
  double slope(double s) const noexcept { return c1 + s * (2 * c2 + s * 3 * c3); }
};

Power power_form(const double (&b)[4], double level) noexcept {
  return {b[0] - level, 3 * (b[1] - b[0]), 3 * ((b[2] - b[1]) - (b[1] - b[0])), (b[3] - b[0]) - 3 * (b[2] - b[1])};
}

/// Root of p between low, where p > 0, and high, where p <= 0: Newton's method kept inside by halving.
double root_between(const Power& p, double low, double high) noexcept {
  const double at_low = p.value(low), at_high = p.value(high);
  double s = low + (high - low) * (at_low / (at_low - at_high));
  for (int i = 0; i < kMaxNewton; ++i) {
    const double v = p.value(s);
    (v > 0 ? low : high) = s;
    double next = s - v / p.slope(s);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double change = std::abs(next - s);
    s = next;
    if (change <= kNearRoot * s) break;  // the error of a Newton step is about its square
  }
  return s;
}

/// First root of p on [0, 1], where p(0) > 0, or kNever. Approximate.
double first_root(const Power& p) noexcept {
  const double discriminant = p.c2 * p.c2 - 3 * p.c1 * p.c3;
  double turn[2] = {kNever, kNever};
  if (discriminant > 0) {
    const double h = -(p.c2 + std::copysign(std::sqrt(discriminant), p.c2));
    turn[0] = h / (3 * p.c3);
    turn[1] = p.c1 / h;
    if (turn[0] > turn[1]) std::swap(turn[0], turn[1]);
  }
  double low = 0;
  for (const double s : turn) {
    if (!(s > low && s < 1)) continue;
    if (p.value(s) <= 0) return root_between(p, low, s);
    low = s;
  }
  return p.value(1) <= 0 ? root_between(p, low, 1) : kNever;
}

/// Time in [0, 1] before which b > level is proven, near the first at which b falls to 1.5 level; kNever: all of it.
double first_descent(const double (&b)[4], double level) noexcept {
  double s = first_root(power_form(b, 1.5 * level));
  double left[4], right[4];
  int pieces = kMaxPieces;
  if (s >= 1) {
    const double proven = proven_above(b, level, 0.2 * level, kMaxHalvings, pieces);
    return proven < 1 ? proven : s > 1 ? kNever : 1;
  }
  for (double back = 0x1p-50; back < 1; back *= 64) {
    subdivide(b, s, left, right);
    if (all_above(left, level)) return s;
    if (left[3] > level) break;
    s *= 1 - back;
  }
  return s * proven_above(left, level, 0.2 * level, kMaxHalvings, pieces);
}

}  // namespace

double next_nonpositive(const Cubic& c, double from) noexcept {
  if (from > 1) return kNever;
  if (from == 0) {
    if (may_be_nonpositive(c, c.b[0])) return 0;
    if (all_above(c.b, c.error)) return kNever;
    const double s = first_descent(c.b, c.error);
    return s > 1 ? kNever : s * (1 - 4 * kRoundoff);
  }
  double left[4], right[4];
  subdivide(c.b, from, left, right);
  if (may_be_nonpositive(c, right[0])) return from;
  if (all_above(right, c.error)) return kNever;
  const double s = first_descent(right, c.error);
  if (s > 1) return kNever;
  return std::max(from, (from + s * (1 - from)) * (1 - 4 * kRoundoff));
}

double next_zero(const Cubic& c, double from) noexcept {
  if (from > 1) return kNever;
  const double now = from == 0 ? c.b[0] : value(c, from);
  return now < 0 ? next_nonpositive(negated(c), from) : next_nonpositive(c, from);
}

}  // namespace kt::bernstein
