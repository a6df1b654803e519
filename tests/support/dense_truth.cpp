#include "tests/support/dense_truth.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace kt {

VectorX symmetric_eigenvalues(const MatrixX& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixX>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorX generalized_eigenvalues(const MatrixX& A, const MatrixX& B) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX>(A, B, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixX solve_symmetric(const MatrixX& A, const MatrixX& b) { return A.ldlt().solve(b); }

}  // namespace kt
