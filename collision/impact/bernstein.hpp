#pragma once
// Polynomials of time in Bernstein form whose coefficients are known up to a bound: when can they first vanish?
// On [0, 1] such a polynomial lies between its smallest and its largest coefficient, so coefficients of one sign prove
// that there is no root. Derivation of the bounds: docs/collision.md.
#include <algorithm>
#include <cmath>

namespace kt::bernstein {

constexpr double kRoundoff = 0x1p-53;  // u: relative error of one operation
constexpr double kNever = 2;           // a time after the end
/// What underflow can add to any coefficient: some dozen products off by 2^-1075, times a coordinate of 2^101.
constexpr double kUnderflow = 0x1p-960;

/// Cubic on [0, 1]. A quadratic or linear polynomial is written as a cubic.
struct Cubic {
  double b[4];    ///< coefficients
  double error;   ///< bound on |true value - computed value|, the rounding of at most two subdivisions included
  bool is_exact;  ///< b[0] and b[3] have the true sign, and are zero only where the true ones are
};

inline double largest_coefficient(const Cubic& c) noexcept {
  return std::max(std::max(std::abs(c.b[0]), std::abs(c.b[1])), std::max(std::abs(c.b[2]), std::abs(c.b[3])));
}

/// The error completed: `coefficient_error` is that of the coefficients themselves.
inline Cubic make_cubic(double b0, double b1, double b2, double b3, double coefficient_error, bool is_exact) noexcept {
  Cubic out{{b0, b1, b2, b3}, 0, is_exact};
  out.error = coefficient_error + 20 * kRoundoff * largest_coefficient(out) + kUnderflow;
  return out;
}

/// The quadratic with coefficients q0, middle / 2, q2.
inline Cubic make_cubic_of_quadratic(double q0, double middle, double q2, double coefficient_error,
                                     bool is_exact) noexcept {
  constexpr double kThird = 1.0 / 3;
  return make_cubic(q0, kThird * (q0 + middle), kThird * (middle + q2), q2, coefficient_error, is_exact);
}

inline Cubic negated(const Cubic& c) noexcept { return {{-c.b[0], -c.b[1], -c.b[2], -c.b[3]}, c.error, c.is_exact}; }

inline double value(const Cubic& c, double s) noexcept {
  const double r = 1 - s;
  const double b01 = r * c.b[0] + s * c.b[1], b12 = r * c.b[1] + s * c.b[2], b23 = r * c.b[2] + s * c.b[3];
  return r * (r * b01 + s * b12) + s * (r * b12 + s * b23);
}

/// Change of c per unit of s, not bounded.
inline double slope(const Cubic& c, double s) noexcept {
  const double r = 1 - s, d0 = c.b[1] - c.b[0], d1 = c.b[2] - c.b[1], d2 = c.b[3] - c.b[2];
  return 3 * (r * (r * d0 + s * d1) + s * (r * d1 + s * d2));
}

/// Can c, which has this value, be negative or zero?
inline bool may_be_nonpositive(const Cubic& c, double value_now) noexcept { return value_now <= 2 * c.error; }

/// A time before which, from `from` on, c is certainly positive, and as late as the bound allows; `from` when c may be
/// nonpositive there; kNever when c is certainly positive on [from, 1].
double next_nonpositive(const Cubic& c, double from) noexcept;
/// The same for c = 0.
double next_zero(const Cubic& c, double from) noexcept;

}  // namespace kt::bernstein
