// The only file that sees CHOLMOD. Supernodal; ordered by AMD or METIS, whichever fills in less, on the graph of the
// nodes where the matrix is made of 3 x 3 node blocks.
#include <cholmod.h>
#include <omp.h>

#include <mutex>

#include "core/sparse_product.hpp"
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

/// One row and column for each node of a matrix in whole 3 x 3 blocks, lower triangle.
struct NodeGraph {
  explicit NodeGraph(const SparseMatrix& m) {
    begin.push_back(0);
    for (int c = 0; c < m.cols(); c += 3) {
      for (int k = m.outerIndexPtr()[c]; k < m.outerIndexPtr()[c + 1]; k += 3)
        if (m.innerIndexPtr()[k] >= c) rows.push_back(m.innerIndexPtr()[k] / 3);
      begin.push_back(static_cast<int>(rows.size()));
    }
    view.nrow = view.ncol = begin.size() - 1;
    view.nzmax = rows.size();
    view.p = begin.data();
    view.i = rows.data();
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_PATTERN;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
  }
  std::vector<int> begin, rows;
  cholmod_sparse view{};
};

/// CHOLMOD 3 starts four OpenMP threads per supernode, whatever the machine. On few cores they mostly wait for one
/// another (a factorization takes twice as long) and take time from the haptic thread.
///
/// And one caller at a time: two threads that factor at once get wrong factors (a matrix that is positive definite is
/// told not to be), since the OpenBLAS without threads below it may not be entered twice.
class OneThread {
 public:
  OneThread() : lock_(mutex()), levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~OneThread() { omp_set_max_active_levels(levels_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::scoped_lock<std::mutex> lock_;
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
      factor_ = analyze(matrix, view);
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
  /// A third of the unknowns to order: twice as fast as on the matrix itself, and the nodes' rows stay together.
  cholmod_factor* analyze(const SparseMatrix& matrix, cholmod_sparse& view) {
    common_.nmethods = 2;
    common_.method[0].ordering = CHOLMOD_AMD;
    common_.method[1].ordering = CHOLMOD_METIS;
    if (!has_node_blocks(matrix)) return cholmod_analyze(&view, &common_);
    NodeGraph graph(matrix);
    cholmod_factor* order = cholmod_analyze(&graph.view, &common_);
    if (!order) return nullptr;
    std::vector<int> permutation;
    for (std::size_t i = 0; i < order->n; ++i)
      for (int c = 0; c < 3; ++c) permutation.push_back(3 * static_cast<int*>(order->Perm)[i] + c);
    cholmod_free_factor(&order, &common_);
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    return cholmod_analyze_p(&view, permutation.data(), nullptr, 0, &common_);
  }

  mutable cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  SparsityPattern pattern_;  // of factor_
};

}  // namespace

std::unique_ptr<SparseSolver> make_cholmod_solver() { return std::make_unique<CholmodSolver>(); }

}  // namespace kt
