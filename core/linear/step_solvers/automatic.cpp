// By size. Conjugate gradients are the faster at any (docs/accuracy_and_speed.md); the factorization, which is exact
// and cannot fail to converge, serves where it takes no longer, and once conjugate gradients have taken more
// iterations than it costs, or have failed: on thin shells full of slivers.
#include <utility>

#include "core/linear/step_solver.hpp"

namespace kt {
namespace {

class Automatic final : public StepSolver {
 public:
  explicit Automatic(StepSolverOptions options) : direct_(make_step_solver("direct", {})) {
    constexpr Eigen::Index kFewNodes = 200;
    constexpr int kFactorization = 500;  // costs as many iterations: 130 for 1,200 nodes, 420 for 8,000, more for more
    options.most_iterations = kFactorization;
    if (options.positions.size() >= 3 * kFewNodes) iterative_ = make_step_solver("pcg", std::move(options));
  }

  bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    return solve(matrix, rhs, x, &StepSolver::solve);
  }
  bool solve_roughly(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    return solve(matrix, rhs, x, &StepSolver::solve_roughly);
  }
  void put_beside(const MatrixEntries& entries) override { beside_ = entries; }
  int iterations() const override { return iterations_; }

 private:
  using Solve = bool (StepSolver::*)(const SparseMatrix&, const VectorX&, VectorX&);
  bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x, Solve iterate) {
    iterations_ = 0;
    const MatrixEntries beside = std::exchange(beside_, {});
    if (iterative_) {
      iterative_->put_beside(beside);
      const bool good = (iterative_.get()->*iterate)(matrix, rhs, x);
      iterations_ = iterative_->iterations();
      if (good) return true;
    }
    direct_->put_beside(beside);
    if (!direct_->solve(matrix, rhs, x)) return false;  // not for lack of convergence: the next may be definite
    iterative_.reset();
    return true;
  }
  std::unique_ptr<StepSolver> direct_, iterative_;  // iterative: only while it serves
  MatrixEntries beside_;                            // of the next solve
  int iterations_ = 0;
};

}  // namespace

std::unique_ptr<StepSolver> make_automatic_step_solver(StepSolverOptions options) {
  return std::make_unique<Automatic>(std::move(options));
}

}  // namespace kt
