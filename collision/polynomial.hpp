#pragma once
// Polynomials of time of degree up to six in Bernstein form that carry a bound on their rounding through sums and
// products. Less sharp than the bounds of four_points.cpp, which know every operation.
#include <algorithm>
#include <cmath>

#include "collision/bernstein.hpp"

namespace kt::bernstein {

struct Polynomial {
  static constexpr int kMaxDegree = 6;
  int degree = 0;
  double b[kMaxDegree + 1] = {};
  double size = 0;   ///< largest magnitude of a coefficient
  double error = 0;  ///< bound on how far any coefficient, and so any value on [0, 1], is from the true one
};

/// a (1-t) + b t, where both are known to `error`.
Polynomial line(double a, double b, double error) noexcept;
Polynomial operator+(const Polynomial& p, const Polynomial& q) noexcept;
Polynomial operator-(const Polynomial& p, const Polynomial& q) noexcept;
Polynomial operator*(const Polynomial& p, const Polynomial& q) noexcept;
Polynomial operator*(double factor, const Polynomial& p) noexcept;

/// A time before which, from `from` on, p is certainly positive; `from` when it may not be there; kNever: to the end.
double next_nonpositive(const Polynomial& p, double from) noexcept;

}  // namespace kt::bernstein
