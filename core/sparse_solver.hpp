#pragma once
// Sparse direct solver for symmetric positive definite matrices: CHOLMOD, or Eigen's LDLT in the minimal build.
#include <memory>

#include "core/types.hpp"

namespace kt {

/// Keeps its symbolic analysis while the pattern stays the same: factor() again is then much cheaper.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;
  /// Factors the symmetric matrix (lower triangle read). False when it is not positive definite.
  virtual bool factor(const SparseMatrix& matrix) = 0;
  /// Solves for one or many right-hand sides, (n x k).
  virtual MatrixX solve(const MatrixX& rhs) const = 0;
  /// The symbolic analysis of another solver of the same kind, for a matrix of the pattern that it factored last.
  virtual void take_analysis(const SparseSolver& /*other*/) {}
};

std::unique_ptr<SparseSolver> make_sparse_solver();

}  // namespace kt
