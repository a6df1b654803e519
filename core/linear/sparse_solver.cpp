#include "core/linear/sparse_solver.hpp"

#include <Eigen/SparseCholesky>

#include "core/linear/sparsity_pattern.hpp"

namespace kt {
#if KT_WITH_CHOLMOD
std::unique_ptr<SparseSolver> make_cholmod_solver();  // core/linear/cholmod.cpp
#endif

namespace {

class EigenSolver final : public SparseSolver {
 public:
  bool factor(const SparseMatrix& matrix) override {
    if (pattern_.changes_to(matrix)) llt_.analyzePattern(matrix);
    llt_.factorize(matrix);
    return llt_.info() == Eigen::Success;
  }
  MatrixX solve(const MatrixX& rhs) const override { return llt_.solve(rhs); }

 private:
  Eigen::SimplicialLLT<SparseMatrix> llt_;
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
