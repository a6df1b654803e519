#pragma once
// Dense matrices of any size, solved by Eigen in one compiled place: its eigen-solvers and complex factorizations take
// 5 to 20 s of compile time in every file that names them. Not for the haptic tick: each call allocates.
#include <complex>
#include <memory>

#include "core/base/types.hpp"

namespace kt {

using ComplexMatrix = Eigen::MatrixXcd;

/// Eigenvalues in ascending order, and their eigenvectors as columns.
struct EigenPairs {
  VectorX values;
  MatrixX vectors;
};

/// A v = l B v of a symmetric A and a positive definite B. V^T B V is the identity.
EigenPairs generalized_eigen(const MatrixX& A, const MatrixX& B);

/// The largest |l| of A v = l v, for any square A.
double spectral_radius(const MatrixX& A);

/// The shortest of all x that bring A x nearest to b.
ComplexMatrix solve_least_squares(const ComplexMatrix& A, const ComplexMatrix& b);

/// LU factors, with row pivots, of a square complex matrix.
class ComplexLu {
 public:
  explicit ComplexLu(const ComplexMatrix& A);
  ~ComplexLu();
  ComplexMatrix solve(const ComplexMatrix& b) const;

 private:
  struct Factors;
  std::unique_ptr<const Factors> factors_;
};

}  // namespace kt
