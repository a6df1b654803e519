#pragma once
// Polynomials of time in Bernstein form whose coefficients are known up to a bound: when can they first vanish?
// On [0, 1] such a polynomial lies between its smallest and its largest coefficient, so coefficients of one sign prove
// that there is no root. Derivation of the bounds: docs/collision.md.
namespace kt::bernstein {

constexpr double kRoundoff = 0x1p-53;  // u: relative error of one operation
constexpr double kNever = 2;           // a time after the end
/// What underflow can add to any coefficient here: some dozen products, each off by 2^-1075 at most.
constexpr double kUnderflow = 0x1p-1000;

/// Cubic on [0, 1]. A quadratic or linear polynomial is written as a cubic.
struct Cubic {
  double b[4];    ///< coefficients
  double error;   ///< bound on |true value - computed value|, the rounding of at most two subdivisions included
  bool is_exact;  ///< b[0] and b[3] have the true sign, and are zero only where the true ones are
};

/// b with its error completed: `coefficient_error` is that of b itself.
Cubic make_cubic(double b0, double b1, double b2, double b3, double coefficient_error, bool is_exact) noexcept;
/// The quadratic with coefficients q0, middle / 2, q2.
Cubic make_cubic_of_quadratic(double q0, double middle, double q2, double coefficient_error, bool is_exact) noexcept;

Cubic negated(const Cubic& c) noexcept;
double largest_coefficient(const Cubic& c) noexcept;
double value(const Cubic& c, double s) noexcept;
/// Change of c per unit of s, not bounded.
double slope(const Cubic& c, double s) noexcept;

/// Can c be negative or zero at s?
inline bool may_be_nonpositive(const Cubic& c, double value_at_s) noexcept { return value_at_s <= 2 * c.error; }

/// A time before which, from `from` on, c is certainly positive, and as late as the bound allows; `from` when c may be
/// nonpositive there; kNever when c is certainly positive on [from, 1].
double next_nonpositive(const Cubic& c, double from) noexcept;
/// The same for c = 0.
double next_zero(const Cubic& c, double from) noexcept;

}  // namespace kt::bernstein
