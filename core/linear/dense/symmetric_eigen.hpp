#pragma once
// All eigenvalues and eigenvectors of a symmetric matrix, as Eigen's solver finds them (Householder's tridiagonal form,
// implicit QR steps), in loops for every vector width: the same bits at each, and without a lock, as LAPACK would need.
#include "core/base/types.hpp"

namespace kt {

struct SymmetricEigen {
  VectorX values;   ///< ascending
  MatrixX vectors;  ///< a column each, orthonormal
};

/// @param A  symmetric, both triangles read. Throws RunError where an entry is not finite.
SymmetricEigen symmetric_eigen(const MatrixX& A);

}  // namespace kt
