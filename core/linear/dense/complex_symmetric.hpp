#pragma once
// A full complex matrix A = A^T, as the dynamic stiffness K - w^2 M + i w D of a local model is, in block factors
// L P^-1 L^T without pivots: a quarter of the work of an LU, in the products that all of a refresh is made of, with the
// same bits on every processor. Without pivots it is stable where the imaginary part is positive definite (Golub and
// Van Loan, section 4.2), or where what is not is diagonal.
#include <complex>

#include "core/base/types.hpp"

namespace kt {

class ComplexSymmetric {
 public:
  /// @param real, imaginary  parts of A, (n x n), the lower triangles are read
  ComplexSymmetric(const MatrixX& real, const MatrixX& imaginary);
  /// A^-1 b, (n x k). Not finite where a block on the diagonal is singular.
  Eigen::MatrixXcd solve(const Eigen::MatrixXcd& b) const;

 private:
  struct Parts {
    RowMatrix real, imaginary;
  };
  Eigen::Index size_;
  Parts lower_;     ///< L, unit blocks on the diagonal left out
  Parts inverses_;  ///< P, of each block on the diagonal, below one another
};

}  // namespace kt
