#pragma once
// Solves the linear systems of successive time steps, which resemble one another. Backends: step_solvers.def.
#include <memory>
#include <string>
#include <vector>

#include "core/base/backend.hpp"
#include "core/base/types.hpp"

namespace kt {

using MatrixEntries = std::vector<Eigen::Triplet<double>>;

class StepSolver {
 public:
  virtual ~StepSolver() = default;
  /// Solves matrix x = rhs; matrix symmetric, both triangles stored, in whole 3 x 3 node blocks. `x` holds a guess on
  /// entry. False, and x is of no use, when the matrix is not positive definite or an
  /// iterative solver does not converge.
  virtual bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) = 0;
  /// The same to a thousandth: for what is only looked ahead with.
  virtual bool solve_roughly(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) {
    return solve(matrix, rhs, x);
  }
  /// The next solve's matrix has these, too: symmetric, positive semidefinite, few, and between nodes that the matrix
  /// does not couple, so that its pattern and what is kept for that stay.
  virtual void put_beside(const MatrixEntries& entries) = 0;
  /// That the last solve took; 0 of a direct solver.
  virtual int iterations() const { return 0; }
};

struct StepSolverOptions {
  VectorX positions;           ///< of the nodes of the system, (3 free) [m]: how it can move as a rigid body
  double tolerance = 1e-6;     ///< pcg: |residual| / |rhs|
  int most_iterations = 2000;  ///< pcg: it does not converge, where it takes more
};

std::vector<BackendInfo> step_solver_backends();

/// Throws InputError for an unknown name.
std::unique_ptr<StepSolver> make_step_solver(const std::string& name, StepSolverOptions options);

}  // namespace kt
