#include "core/linear/dense/dense_solvers.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace kt {

EigenPairs generalized_eigen(const MatrixX& A, const MatrixX& B) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(A, B);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

double spectral_radius(const MatrixX& A) {
  return Eigen::EigenSolver<MatrixX>(A, false).eigenvalues().cwiseAbs().maxCoeff();
}

ComplexMatrix solve_least_squares(const ComplexMatrix& A, const ComplexMatrix& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

struct ComplexLu::Factors {
  Eigen::PartialPivLU<ComplexMatrix> lu;
};

ComplexLu::ComplexLu(const ComplexMatrix& A)
    : factors_(std::make_unique<const Factors>(Factors{Eigen::PartialPivLU<ComplexMatrix>(A)})) {}
ComplexLu::~ComplexLu() = default;

ComplexMatrix ComplexLu::solve(const ComplexMatrix& b) const { return factors_->lu.solve(b); }

}  // namespace kt
