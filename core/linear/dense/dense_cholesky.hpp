#pragma once
// Cholesky factors of small dense matrices, inverted: where a factor serves for hundreds of right-hand sides, products
// with its inverse are several times faster than triangular solves. The same bits at every vector width; no lock.
#include <optional>

#include "core/base/types.hpp"

namespace kt {

/// L^-1 of A = L L^T, (n x n). Nothing when a pivot is not above `least` times A's own diagonal entry.
/// @param A  symmetric, lower triangle read
std::optional<RowMatrix> inverse_factor(const MatrixX& A, double least = 0);

/// Whether A has a Cholesky factor. A third of inverse_factor()'s work.
/// @param A  symmetric, lower triangle read
bool is_positive_definite(const MatrixX& A);

/// L^-1 of a lower triangular matrix without zeros on its diagonal.
RowMatrix invert_lower(const MatrixX& L);

/// A^-1 from its inverse factor: L^-T L^-1.
MatrixX inverse_from(const RowMatrix& inverse_factor);

}  // namespace kt
