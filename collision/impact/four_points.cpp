#include "collision/impact/four_points.hpp"

#include <cmath>
#include <limits>

namespace kt {
namespace {

using bernstein::Cubic;
using bernstein::kRoundoff;
using bernstein::kUnderflow;

// Bounds on the rounding of a coefficient, in u times its magnitude; derived in docs/collision.md.
constexpr double kVolumeError = 13 * kRoundoff;
constexpr double kAreaError = 9 * kRoundoff;
constexpr double kAreaDifferenceError = 11 * kRoundoff;
constexpr double kGapError = 9 * kRoundoff;
constexpr double kEstimateError = 6 * kRoundoff;

constexpr double kThird = 1.0 / 3;

Quadratic<double> operator-(const Quadratic<double>& a, const Quadratic<double>& b) noexcept {
  return {a.q0 - b.q0, a.middle - b.middle, a.q2 - b.q2};
}
Quadratic<Expansion> operator-(const Quadratic<Expansion>& a, const Quadratic<Expansion>& b) noexcept {
  return {a.q0 - b.q0, a.middle - b.middle, a.q2 - b.q2};
}

Cubic rounded_cubic(const Quadratic<double>& q, double error) noexcept {
  return bernstein::make_cubic_of_quadratic(q.q0, q.middle, q.q2, error, false);
}

Cubic rounded_line(double at_t0, double at_t1, double error) noexcept {
  return bernstein::make_cubic(at_t0, kThird * (2 * at_t0 + at_t1), kThird * (at_t0 + 2 * at_t1), at_t1, error, false);
}

double unless_too_large(bool fits, double error) noexcept {
  return fits ? error : std::numeric_limits<double>::infinity();
}

Quadratic<double> estimate(const Quadratic<Expansion>& q) noexcept {
  return {q.q0.estimate(), q.middle.estimate(), q.q2.estimate()};
}
double estimate_error(const Quadratic<Expansion>& q, const Quadratic<double>& rounded) noexcept {
  const double size = std::abs(rounded.q0) + std::abs(rounded.middle) + std::abs(rounded.q2);
  return unless_too_large(q.q0.fits() && q.middle.fits() && q.q2.fits(), kEstimateError * size);
}

Cubic exact_cubic(const Quadratic<Expansion>& q) noexcept {
  const Quadratic<double> r = estimate(q);
  return bernstein::make_cubic_of_quadratic(r.q0, r.middle, r.q2, estimate_error(q, r), true);
}

Cubic exact_line(const Expansion& at_t0, const Expansion& at_t1) noexcept {
  const double a = at_t0.estimate(), b = at_t1.estimate();
  const double error =
      unless_too_large(at_t0.fits() && at_t1.fits(), kEstimateError * std::max(std::abs(a), std::abs(b)));
  return bernstein::make_cubic(a, kThird * (2 * a + b), kThird * (a + 2 * b), b, error, true);
}

}  // namespace

RoundedMotion::RoundedMotion(FeaturePair pair, const MovingPoints& x) noexcept : pair_(pair) {
  const VectorPlaces of = vector_places(pair);
  for (int t = 0; t < 2; ++t)
    for (int k = 0; k < 3; ++k) {
      v_.e1[t][k] = x.at(t, of.e1[0])[k] - x.at(t, of.e1[1])[k];
      v_.e2[t][k] = x.at(t, of.e2[0])[k] - x.at(t, of.e2[1])[k];
      v_.d[t][k] = x.at(t, of.d[0])[k] - x.at(t, of.d[1])[k];
    }
  for (int k = 0; k < 3; ++k) {
    e1_max_[k] = std::max(std::abs(v_.e1[0][k]), std::abs(v_.e1[1][k]));
    e2_max_[k] = std::max(std::abs(v_.e2[0][k]), std::abs(v_.e2[1][k]));
    d_max_[k] = std::max(std::abs(v_.d[0][k]), std::abs(v_.d[1][k]));
  }
  double size = 0, f[4];
  for (int k = 0; k < 3; ++k) {
    n_[k] = cross_component(v_.e1, v_.e2, k);
    size += d_max_[k] * magnitude(e1_max_, e2_max_, k);
  }
  volume_coefficients(n_, v_.d, f);
  distance_ = bernstein::make_cubic(f[0], kThird * f[1], kThird * f[2], f[3], kVolumeError * size, false);
}

int RoundedMotion::inside(int k, Cubic (&out)[4]) const noexcept {
  const double n_size = magnitude(e1_max_, e2_max_, k), d_e1_size = magnitude(e1_max_, d_max_, k),
               d_e2_size = magnitude(e2_max_, d_max_, k);
  const Quadratic<double> first = cross_component(v_.d, v_.e2, k);
  out[0] = rounded_cubic(first, kAreaError * d_e2_size);
  if (pair_ == FeaturePair::vertex_face) {
    const Quadratic<double> second = cross_component(v_.e1, v_.d, k);
    out[1] = rounded_cubic(second, kAreaError * d_e1_size);
    out[2] = rounded_cubic(n_[k] - first - second, kAreaDifferenceError * (n_size + d_e1_size + d_e2_size));
    return 3;
  }
  const Quadratic<double> second = cross_component(v_.d, v_.e1, k);
  out[1] = rounded_cubic(n_[k] - first, kAreaDifferenceError * (n_size + d_e2_size));
  out[2] = rounded_cubic(second, kAreaError * d_e1_size);
  out[3] = rounded_cubic(n_[k] - second, kAreaDifferenceError * (n_size + d_e1_size));
  return 4;
}

int RoundedMotion::gaps(int k, Cubic (&out)[4]) const noexcept {
  const double error = kGapError * (e1_max_[k] + e2_max_[k] + d_max_[k]);
  const auto line = [&](double e1, double e2) {
    return rounded_line(v_.d[0][k] + e2 * v_.e2[0][k] + e1 * v_.e1[0][k],
                        v_.d[1][k] + e2 * v_.e2[1][k] + e1 * v_.e1[1][k], error);
  };
  out[0] = line(0, 0);
  out[1] = line(-1, 0);
  if (pair_ == FeaturePair::vertex_face) {
    out[2] = line(0, -1);
    return 3;
  }
  out[2] = line(0, 1);
  out[3] = line(-1, 1);
  return 4;
}

bool touch_at_start(FeaturePair pair, const MovingPoints& x, int k) noexcept {
  const VectorPlaces of = vector_places(pair);
  Expansion e1[3], e2[3], d[3], volume;
  for (int i = 0; i < 3; ++i) {
    e1[i] = Expansion::difference(x.at(0, of.e1[0])[i], x.at(0, of.e1[1])[i]);
    e2[i] = Expansion::difference(x.at(0, of.e2[0])[i], x.at(0, of.e2[1])[i]);
    d[i] = Expansion::difference(x.at(0, of.d[0])[i], x.at(0, of.d[1])[i]);
  }
  const auto cross = [](const Expansion(&a)[3], const Expansion(&b)[3], int axis) {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    return a[i] * b[j] - a[j] * b[i];
  };
  Expansion n_k;
  for (int i = 0; i < 3; ++i) {
    const Expansion n_i = cross(e1, e2, i);
    if (i == k) n_k = n_i;
    volume = volume + n_i * d[i];
  }
  if (!volume.fits() || volume.size() > 0) return false;
  const bool is_face = pair == FeaturePair::vertex_face;
  const Expansion first = cross(d, e2, k), second = is_face ? cross(e1, d, k) : cross(d, e1, k);
  const auto has_no_other_sign = [normal = n_k.estimate()](const Expansion& area) {
    return area.fits() && (normal > 0 ? area.estimate() >= 0 : normal < 0 && area.estimate() <= 0);
  };
  return has_no_other_sign(first) && has_no_other_sign(second) &&
         (is_face ? has_no_other_sign(n_k - first - second)
                  : has_no_other_sign(n_k - first) && has_no_other_sign(n_k - second));
}

ExactVectors exact_vectors(FeaturePair pair, const MovingPoints& x) noexcept {
  const VectorPlaces of = vector_places(pair);
  ExactVectors v;
  for (int t = 0; t < 2; ++t)
    for (int k = 0; k < 3; ++k) {
      v.e1[t][k] = Expansion::difference(x.at(t, of.e1[0])[k], x.at(t, of.e1[1])[k]);
      v.e2[t][k] = Expansion::difference(x.at(t, of.e2[0])[k], x.at(t, of.e2[1])[k]);
      v.d[t][k] = Expansion::difference(x.at(t, of.d[0])[k], x.at(t, of.d[1])[k]);
    }
  return v;
}

ExactVectors restricted(const ExactVectors& v, double low, double high) noexcept {
  ExactVectors out;
  const auto restrict_one = [&](const Expansion(&x)[2][3], Expansion(&y)[2][3]) {
    for (int k = 0; k < 3; ++k) {
      const Expansion change = x[1][k] - x[0][k];
      y[0][k] = low == 0 ? x[0][k] : x[0][k] + change * low;
      y[1][k] = high == 1 ? x[1][k] : x[0][k] + change * high;
    }
  };
  restrict_one(v.e1, out.e1);
  restrict_one(v.e2, out.e2);
  restrict_one(v.d, out.d);
  return out;
}

ExactMotion::ExactMotion(FeaturePair pair, const ExactVectors& vectors) noexcept : pair_(pair), v_(vectors) {
  for (int k = 0; k < 3; ++k) {
    n_[k] = cross_component(v_.e1, v_.e2, k);
    const Quadratic<double> q = estimate(n_[k]);
    normal_[k] = {q, 2 * estimate_error(n_[k], q) + kUnderflow};
  }
  Expansion f[4];
  volume_coefficients(n_, v_.d, f);
  double b[4], largest = 0;
  bool fits = true;
  for (int i = 0; i < 4; ++i) {
    b[i] = f[i].estimate();
    largest = std::max(largest, std::abs(b[i]));
    fits = fits && f[i].fits();
  }
  distance_ = bernstein::make_cubic(b[0], kThird * b[1], kThird * b[2], b[3],
                                    unless_too_large(fits, kEstimateError * largest), true);
}

int ExactMotion::find_inside(int k, Cubic (&out)[4]) const noexcept {
  const Quadratic<Expansion> first = cross_component(v_.d, v_.e2, k);
  out[0] = exact_cubic(first);
  if (pair_ == FeaturePair::vertex_face) {
    const Quadratic<Expansion> second = cross_component(v_.e1, v_.d, k);
    out[1] = exact_cubic(second);
    out[2] = exact_cubic(n_[k] - first - second);
    return 3;
  }
  const Quadratic<Expansion> second = cross_component(v_.d, v_.e1, k);
  out[1] = exact_cubic(n_[k] - first);
  out[2] = exact_cubic(second);
  out[3] = exact_cubic(n_[k] - second);
  return 4;
}

int ExactMotion::find_gaps(int k, Cubic (&out)[4]) const noexcept {
  const auto set = [&](Cubic& line, bool minus_e1, int e2) {
    Expansion at[2] = {v_.d[0][k], v_.d[1][k]};
    for (int t = 0; t < 2; ++t) {
      if (minus_e1) at[t] = at[t] - v_.e1[t][k];
      if (e2 != 0) at[t] = e2 > 0 ? at[t] + v_.e2[t][k] : at[t] - v_.e2[t][k];
    }
    line = exact_line(at[0], at[1]);
  };
  set(out[0], false, 0);
  set(out[1], true, 0);
  if (pair_ == FeaturePair::vertex_face) {
    set(out[2], false, -1);
    return 3;
  }
  set(out[2], false, 1);
  set(out[3], true, 1);
  return 4;
}

}  // namespace kt
