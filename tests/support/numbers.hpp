#pragma once
// Independent numbers to test against: central differences, seeded random vectors, relative errors.
#include <functional>

#include "core/base/types.hpp"

namespace kt {

/// Jacobian of f at x by central differences of step `eps`, (f(x) x x).
MatrixX central_differences(const std::function<VectorX(const VectorX&)>& f, const VectorX& x, double eps);

/// || a - b || / || b ||, Frobenius; the absolute norm when b = 0.
double relative_error(const MatrixX& a, const MatrixX& b);

/// n numbers in [-1, 1), the same on every machine and compiler.
VectorX random_vector(Eigen::Index n, unsigned seed);

/// Symmetric positive definite (n x n), smallest eigenvalue >= 1, condition below 10.
MatrixX random_positive_definite(Eigen::Index n, unsigned seed);

}  // namespace kt
