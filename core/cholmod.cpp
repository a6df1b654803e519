// The only file that sees CHOLMOD. Supernodal with its default ordering choice (AMD, or METIS when it is better).
#include <cholmod.h>
#include <omp.h>

#include "core/sparse_solver.hpp"
#include "core/sparsity_pattern.hpp"

namespace kt {
namespace {

cholmod_sparse view_of(const SparseMatrix& m) {
  cholmod_sparse view{};
  view.nrow = static_cast<size_t>(m.rows());
  view.ncol = static_cast<size_t>(m.cols());
  view.nzmax = static_cast<size_t>(m.nonZeros());
  view.p = const_cast<int*>(m.outerIndexPtr());
  view.i = const_cast<int*>(m.innerIndexPtr());
  view.x = const_cast<double*>(m.valuePtr());
  view.stype = -1;  // symmetric, lower triangle read
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

/// CHOLMOD 3 starts four OpenMP threads per supernode, whatever the machine. On few cores they mostly wait for one
/// another (a factorization takes twice as long) and take time from the haptic thread.
class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~OneThread() { omp_set_max_active_levels(levels_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_;
};

class CholmodSolver final : public SparseSolver {
 public:
  CholmodSolver() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_AUTO;
    common_.final_ll = 1;  // L L^T also for small matrices: L D L^T would accept what is not positive definite
  }
  ~CholmodSolver() override {
    if (factor_) cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  bool factor(const SparseMatrix& matrix) override {
    const OneThread one_thread;
    cholmod_sparse view = view_of(matrix);
    if (pattern_.changes_to(matrix) || !factor_) {
      if (factor_) cholmod_free_factor(&factor_, &common_);
      factor_ = cholmod_analyze(&view, &common_);
    }
    if (!factor_) return false;
    cholmod_factorize(&view, factor_, &common_);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  MatrixX solve(const MatrixX& rhs) const override {
    const OneThread one_thread;
    cholmod_dense b{};
    b.nrow = b.d = static_cast<size_t>(rhs.rows());
    b.ncol = static_cast<size_t>(rhs.cols());
    b.nzmax = b.nrow * b.ncol;
    b.x = const_cast<double*>(rhs.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor_, &b, &common_);
    MatrixX out = Eigen::Map<MatrixX>(static_cast<double*>(x->x), rhs.rows(), rhs.cols());
    cholmod_free_dense(&x, &common_);
    return out;
  }

 private:
  mutable cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  SparsityPattern pattern_;  // of factor_
};

}  // namespace

std::unique_ptr<SparseSolver> make_cholmod_solver() { return std::make_unique<CholmodSolver>(); }

}  // namespace kt
