// Sparse Cholesky in every step.
#include <utility>

#include "core/linear/sparse_solver.hpp"
#include "core/linear/step_solver.hpp"

namespace kt {
namespace {

class Direct final : public StepSolver {
 public:
  bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    const MatrixEntries entries = std::exchange(beside_, {});
    const bool is_factored = solver_->factor(matrix);
    if (entries.empty()) {
      if (is_factored) x = solver_->solve(rhs);
      return is_factored;
    }
    SparseMatrix beside(matrix.rows(), matrix.cols());
    beside.setFromTriplets(entries.begin(), entries.end());
    if (is_factored && iterate(matrix, beside, rhs, x)) return true;
    // The body alone may move as a whole: what is beside holds it.
    if (!solver_->factor(matrix + beside)) return false;
    x = solver_->solve(rhs);
    return true;
  }
  void put_beside(const MatrixEntries& entries) override { beside_ = entries; }

 private:
  /// Conjugate gradients on the sum, from the factor of the matrix alone, whose analysis stays so: a step more than the
  /// rank of what is beside, but for rounding.
  bool iterate(const SparseMatrix& matrix, const SparseMatrix& beside, const VectorX& rhs, VectorX& x) const {
    constexpr int kMostSteps = 60;
    constexpr double kTolerance = 1e-11;
    x = solver_->solve(rhs);
    VectorX residual = -(beside * x), direction;
    double before = 0;
    for (int step = 0; step < kMostSteps; ++step) {
      if (residual.norm() <= kTolerance * rhs.norm()) return true;
      const VectorX z = solver_->solve(residual);
      const double now = residual.dot(z);
      if (!(now > 0)) return false;
      direction = step > 0 ? VectorX(z + now / before * direction) : z;
      const VectorX image = matrix.selfadjointView<Eigen::Lower>() * direction + beside * direction;
      const double share = now / direction.dot(image);
      x += share * direction;
      residual -= share * image;
      before = now;
    }
    return false;
  }

  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
  MatrixEntries beside_;  // of the next solve
};

}  // namespace

std::unique_ptr<StepSolver> make_direct_step_solver(StepSolverOptions) { return std::make_unique<Direct>(); }

}  // namespace kt
