// Sparse Cholesky in every step.
#include "core/linear/sparse_solver.hpp"
#include "core/linear/step_solver.hpp"

namespace kt {
namespace {

class Direct final : public StepSolver {
 public:
  bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    if (!solver_->factor(matrix)) return false;
    x = solver_->solve(rhs);
    return true;
  }

 private:
  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
};

}  // namespace

std::unique_ptr<StepSolver> make_direct_step_solver(StepSolverOptions) { return std::make_unique<Direct>(); }

}  // namespace kt
