// Vertices in a canonical order; the search with rounded polynomials; in exact mode, what these leave open is searched
// again in exact arithmetic on a small part of the step around it, where the polynomials' rounding is that much
// smaller.
#include "collision/impact/feature_toi.hpp"

#include <cmath>
#include <type_traits>
#include <utility>

#include "collision/impact/touch.hpp"
#include "collision/impact/touch_times.hpp"

namespace kt {
namespace {

using touch_times::Candidate;
using Status = ToiResult::Status;

constexpr int kMaxParts = 10;                // of the step that are searched in exact arithmetic
constexpr double kFinest = 0x1p-30;          // part of the step in which exact coefficients, rounded, are exact enough
constexpr double kSharp = 0x1p-34;           // of the step: a proven bracket that exact mode does not make smaller
constexpr double kSmallestExact = 0x1p-245;  // below, a product in exact arithmetic could underflow

/// What the search says of the time.
struct Found {
  Status status = Status::none;
  bool is_certain = false;
  double toi = 1, toi_upper = 1;
};

/// A part of the step; base is rounded down.
struct Part {
  double base = 0, width = 1;
  double lower(double s) const noexcept {
    const double offset = s * width, t = base + offset;
    return t - base > offset ? std::nextafter(t, 0) : t;
  }
  double upper(double s) const noexcept {
    const double offset = s * width, t = base + offset;
    return base == 0 ? t : std::min(1.0, t * (1 + 8 * bernstein::kRoundoff));
  }
};

/// Part [low, high] of [0, 1] around s, after which the search would not go on at once.
template <class Motion>
std::pair<double, double> part_around(const Motion& m, double s) noexcept {
  double low = 0, high = 1;
  Candidate next;
  for (const double width : {kFinest, 0x1p-20, 0x1p-10}) {
    low = std::min(std::floor(s / width) * width, 1 - width);
    high = low + width;
    if (high == 1) return {low, high};
    next_candidate(m, high, next);
    if (next.s > high) return {low, high};
  }
  if (std::is_same_v<Motion, RoundedMotion>) return {0, 1};  // its error is that of the whole step
  return {low, high};
}

/// First contact on `part`, where m and v describe the motion, from `from` on.
template <class Motion>
Found search_exactly(const Motion& m, const ExactVectors& v, const Part& part, double from, int& budget) noexcept {
  Candidate c;
  while (from <= 1) {
    next_candidate(m, from, c);
    if (c.s > 1) break;
    const auto until = certain_until(m, c);
    const bool is_sharp = until && (*until - c.s) * part.width <= kSharp;
    const bool is_last = c.is_exhausted || budget == 0;
    if (is_sharp || is_last || part.width <= kFinest)
      return {until || !is_last ? Status::hit : Status::budget_exhausted, until.has_value(), part.lower(c.s),
              until ? part.upper(*until) : 1};
    --budget;
    const auto [low, high] = part_around(m, c.s);
    const Part inner{part.lower(low), part.width * (high - low)};
    const ExactVectors inner_v = restricted(v, low, high);
    const Found found = search_exactly(ExactMotion(m.pair(), inner_v), inner_v, inner, 0, budget);
    if (found.status != Status::none) return found;
    if (high == 1) break;
    from = high;
  }
  return {};
}

bool is_exactly_computable(const MovingPoints& x) noexcept {
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k)
      for (const double c : {x.x_t0[i][k], x.x_t1[i][k]})
        if (c != 0 && std::abs(c) < kSmallestExact) return false;
  return true;
}

/// c: the first candidate of m.
Found judge(const RoundedMotion& m, const Candidate& c, const MovingPoints& x, ToiMode mode) noexcept {
  if (c.s > 1) return {};
  const auto until = certain_until(m, c);
  if (until && (mode == ToiMode::conservative || *until - c.s <= kSharp)) return {Status::hit, true, c.s, *until};
  if (mode == ToiMode::conservative || !is_exactly_computable(x))
    return {c.is_exhausted ? Status::budget_exhausted : Status::hit, until.has_value(), c.s, until.value_or(1)};
  // The usual reason: the features touch at the start, as those do that touched at the end of the step before.
  if (c.s == 0 && touch_at_start(m.pair(), x, c.areas.axis)) return {Status::hit, true, 0, 0};
  int budget = kMaxParts;
  Found found = search_exactly(m, exact_vectors(m.pair(), x), Part{}, c.s, budget);
  found.toi = std::max(found.toi, c.s);  // before which there is no contact in any case
  return found;
}

bool is_valid(const MovingPoints& x) noexcept {
  bool is_small_enough = true;
  double largest = 0;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      const double a = std::abs(x.x_t0[i][k]), b = std::abs(x.x_t1[i][k]);
      is_small_enough &= (a <= kLargestCoordinate) & (b <= kLargestCoordinate);  // false for NaN
      largest = std::max(largest, std::max(a, b));
    }
  return is_small_enough && (largest == 0 || largest >= kSmallestExtent);
}

/// -1, 0, 1: by the coordinates at the start, then by those at the end.
int compare(const MovingPoints& x, int i, int j) noexcept {
  for (int end = 0; end < 2; ++end)
    for (int k = 0; k < 3; ++k) {
      const double a = x.at(end, i)[k], b = x.at(end, j)[k];
      if (a != b) return a < b ? -1 : 1;
    }
  return 0;
}

/// Puts the points into an order that depends on nothing but coordinates; true: edges a and b have changed places.
bool order(FeaturePair pair, MovingPoints& x) noexcept {
  const auto sort = [&](int i, int j) {
    if (compare(x, i, j) > 0) std::swap(x.index[i], x.index[j]);
  };
  sort(2, 3);
  if (pair == FeaturePair::vertex_face) {
    sort(1, 2);
    sort(2, 3);
    return false;
  }
  sort(0, 1);
  const int of_first = compare(x, 0, 2), of_edges = of_first != 0 ? of_first : compare(x, 1, 3);
  if (of_edges <= 0) return false;
  std::swap(x.index[0], x.index[2]);
  std::swap(x.index[1], x.index[3]);
  return true;
}

/// The part of points [begin, end) whose weights are not zero.
ToiFeature feature_of(const bool (&is_zero)[4], int begin, int end) noexcept {
  using Kind = ToiFeature::Kind;
  int zeros = 0, zero = 0, other = begin;
  for (int i = begin; i < end; ++i) {
    zeros += is_zero[i];
    (is_zero[i] ? zero : other) = i;
  }
  const int corners = end - begin - zeros;
  if (corners <= 1) return {Kind::vertex, static_cast<unsigned char>(other)};
  if (corners == 3) return {Kind::face, 0};
  return {Kind::edge, static_cast<unsigned char>(end - begin == 3 ? zero : 0)};
}

ToiResult find(FeaturePair pair, const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], ToiMode mode) noexcept {
  ToiResult out;
  MovingPoints x{x_t0, x_t1};
  if (!is_valid(x)) {
    out.status = Status::invalid_input;
    return out;
  }
  const bool is_swapped = order(pair, x);
  const RoundedMotion m(pair, x);
  Candidate c;
  next_candidate(m, 0, c);
  const Found found = judge(m, c, x, mode);
  out.status = found.status;
  out.is_certain = found.is_certain;
  out.toi = found.toi;
  out.toi_upper = found.toi_upper;
  if (found.status == Status::none) return out;
  if (found.status == Status::hit && (found.is_certain ? found.toi_upper : found.toi) == 0)
    out.status = Status::already_inside;
  if (found.toi != c.s) find_areas(m, found.toi, c.areas);
  const FeatureTouch touch = touch_at(m, found.toi, c.areas);
  bool is_zero[4];
  for (int i = 0; i < 4; ++i) {
    out.weight[x.index[i]] = touch.weight[i];
    is_zero[x.index[i]] = touch.is_zero[i];
  }
  const bool is_face = pair == FeaturePair::vertex_face;
  out.first = is_face ? ToiFeature{ToiFeature::Kind::vertex, 0} : feature_of(is_zero, 0, 2);
  out.second = is_face ? feature_of(is_zero, 1, 4) : feature_of(is_zero, 2, 4);
  out.normal = is_swapped ? Vec3(-touch.normal) : touch.normal;
  return out;
}

}  // namespace

ToiResult vertex_face_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], ToiMode mode) noexcept {
  return find(FeaturePair::vertex_face, x_t0, x_t1, mode);
}

ToiResult edge_edge_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], ToiMode mode) noexcept {
  return find(FeaturePair::edge_edge, x_t0, x_t1, mode);
}

}  // namespace kt
