#include "core/sparse_solver.hpp"

#include <Eigen/SparseCholesky>

namespace kt {
#if KT_WITH_CHOLMOD
std::unique_ptr<SparseSolver> make_cholmod_solver();  // core/cholmod.cpp
#endif

namespace {

class EigenSolver final : public SparseSolver {
 public:
  bool factor(const SparseMatrix& matrix) override {
    const bool same_pattern = matrix.rows() == rows_ && matrix.nonZeros() == non_zeros_;
    if (!same_pattern) llt_.analyzePattern(matrix);
    rows_ = matrix.rows();
    non_zeros_ = matrix.nonZeros();
    llt_.factorize(matrix);
    return llt_.info() == Eigen::Success;
  }
  MatrixX solve(const MatrixX& rhs) const override { return llt_.solve(rhs); }

 private:
  Eigen::SimplicialLLT<SparseMatrix> llt_;
  Eigen::Index rows_ = -1, non_zeros_ = -1;
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
