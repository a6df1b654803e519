#include "core/linear/sparse_solver.hpp"

#include <Eigen/SparseCholesky>

#include "core/linear/copied_solver.hpp"
#include "core/linear/sparsity_pattern.hpp"

namespace kt {
#if KT_WITH_CHOLMOD
std::unique_ptr<SparseSolver> make_cholmod_solver();  // core/linear/cholmod.cpp
#endif

namespace {

class EigenSolver final : public SparseSolver, public CopiedSolver {
 public:
  bool factor(const SparseMatrix& matrix) override {
    const bool is_shared = llt_.use_count() > 1;
    if (is_shared) llt_ = std::make_shared<Factor>();
    if (pattern_.changes_to(matrix) || is_shared) llt_->analyzePattern(matrix);
    llt_->factorize(matrix);
    return llt_->info() == Eigen::Success;
  }
  MatrixX solve(const MatrixX& rhs) const override { return llt_->solve(rhs); }
  std::unique_ptr<SparseSolver> copy() const override { return std::make_unique<EigenSolver>(*this); }

 private:
  using Factor = Eigen::SimplicialLLT<SparseMatrix>;
  std::shared_ptr<Factor> llt_ = std::make_shared<Factor>();  // of copies: until one of them factors again
  SparsityPattern pattern_;
};

}  // namespace

std::unique_ptr<SparseSolver> make_sparse_solver() {
#if KT_WITH_CHOLMOD
  return make_cholmod_solver();
#else
  return std::make_unique<EigenSolver>();
#endif
}

}  // namespace kt
