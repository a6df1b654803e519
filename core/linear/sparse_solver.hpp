#pragma once
// Sparse direct solver for symmetric positive definite matrices: CHOLMOD, or Eigen's LDLT in the minimal build.
#include <memory>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Some columns of a matrix whose rows lie one after another.
using RowsRef = Eigen::Ref<RowMatrix>;

/// Keeps its symbolic analysis while the pattern stays the same: factor() again is then much cheaper.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;
  /// Factors the symmetric matrix (lower triangle read). False when it is not positive definite.
  virtual bool factor(const SparseMatrix& matrix) = 0;
  /// Solves for one or many right-hand sides, (n x k).
  virtual MatrixX solve(const MatrixX& rhs) const = 0;
  /// The same with the right-hand sides side by side in memory, in their place.
  virtual void solve_in_place(RowsRef rhs) const { rhs = solve(rhs); }
  /// The symbolic analysis of another solver of the same kind, for a matrix of the pattern that it factored last.
  virtual void take_analysis(const SparseSolver& /*other*/) {}
  /// Nodes whose rows are to come last in the next analysis: solutions for loads on these then cost half. A wish.
  virtual void order_last(std::vector<int> /*nodes*/) {}
};

std::unique_ptr<SparseSolver> make_sparse_solver();

/// For matrices in whole 3 x 3 node blocks (others are left to the above): own supernodal Cholesky, with the same bits
/// on every processor and in every build, and without a lock.
std::unique_ptr<SparseSolver> make_block_solver();

}  // namespace kt
