#pragma once
// Eigenvalues and solutions of symmetric matrices by Eigen, in one compiled place: each file that names its
// eigen-solvers takes 5 to 20 s to compile.
#include "core/base/types.hpp"

namespace kt {

/// All l of A v = l v of a symmetric A, ascending; the lower triangle is read.
VectorX symmetric_eigenvalues(const MatrixX& A);
/// All l of A v = l B v of a symmetric A and a positive definite B, ascending.
VectorX generalized_eigenvalues(const MatrixX& A, const MatrixX& B);
/// A^-1 b of a symmetric A, by L D L^T with pivots.
MatrixX solve_symmetric(const MatrixX& A, const MatrixX& b);

}  // namespace kt
