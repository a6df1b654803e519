// The only file that sees CHOLMOD. Supernodal; ordered by AMD or METIS, whichever fills in less, on the graph of the
// nodes where the matrix is made of 3 x 3 node blocks.
#include <cholmod.h>
#include <omp.h>

#include <algorithm>
#include <memory>
#include <mutex>

#include "core/linear/copied_solver.hpp"
#include "core/linear/sparse_product.hpp"
#include "core/linear/sparsity_pattern.hpp"

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

/// One workspace of CHOLMOD.
struct Common {
  Common() {
    cholmod_start(&cholmod);
    cholmod.print = 0;
    cholmod.supernodal = CHOLMOD_AUTO;
    cholmod.final_ll = 1;  // L L^T also for small matrices: L D L^T would accept what is not positive definite
  }
  ~Common() { cholmod_finish(&cholmod); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common cholmod{};
};

/// Of a pattern: an order of its rows that fills in little, and the factor's pattern of the matrix in that order. Its
/// lower triangle is kept as CHOLMOD wants it, so that a factorization copies the numbers and turns nothing around.
class Analysis {
 public:
  explicit Analysis(const SparseMatrix& matrix) {
    if (!find_order(matrix)) return;
    arrange(matrix);
    common_.cholmod.nmethods = 1;
    common_.cholmod.method[0].ordering = CHOLMOD_NATURAL;
    common_.cholmod.postorder = 0;  // it is one already
    std::vector<double> values(rows.size(), 0.0);
    cholmod_sparse view = lower(values);
    symbolic_ = cholmod_analyze(&view, &common_.cholmod);
  }
  ~Analysis() {
    if (symbolic_) cholmod_free_factor(&symbolic_, &common_.cholmod);
  }
  Analysis(const Analysis&) = delete;
  Analysis& operator=(const Analysis&) = delete;

  cholmod_factor* copy(Common& into) const {
    return symbolic_ ? cholmod_copy_factor(symbolic_, &into.cholmod) : nullptr;
  }
  cholmod_sparse lower(std::vector<double>& values) const {
    cholmod_sparse view{};
    view.nrow = view.ncol = order.size();
    view.nzmax = rows.size();
    view.p = const_cast<int*>(begin.data());
    view.i = const_cast<int*>(rows.data());
    view.x = values.data();
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = view.packed = 1;
    return view;
  }

  std::vector<int> order;        ///< row of the matrix that comes first, second, ..
  std::vector<int> begin, rows;  ///< of the lower triangle in that order
  std::vector<int> from;         ///< of each of its entries: which of the matrix's it is

 private:
  /// On the nodes' graph a third of the unknowns to order: twice as fast as on the matrix itself, and the nodes' rows
  /// stay together.
  bool find_order(const SparseMatrix& matrix) {
    cholmod_common& common = common_.cholmod;
    cholmod_sparse view = view_of(matrix);
    common.nmethods = 2;
    common.method[0].ordering = CHOLMOD_AMD;
    common.method[1].ordering = CHOLMOD_METIS;
    std::vector<int> permutation;
    if (has_node_blocks(matrix)) {
      NodeGraph graph(matrix);
      cholmod_factor* nodes = cholmod_analyze(&graph.view, &common);
      if (!nodes) return false;
      for (std::size_t i = 0; i < nodes->n; ++i)
        for (int c = 0; c < 3; ++c) permutation.push_back(3 * static_cast<int*>(nodes->Perm)[i] + c);
      cholmod_free_factor(&nodes, &common);
      common.nmethods = 1;
      common.method[0].ordering = CHOLMOD_GIVEN;
    }
    cholmod_factor* all = permutation.empty() ? cholmod_analyze(&view, &common)
                                              : cholmod_analyze_p(&view, permutation.data(), nullptr, 0, &common);
    if (!all) return false;
    order.assign(static_cast<int*>(all->Perm), static_cast<int*>(all->Perm) + all->n);
    cholmod_free_factor(&all, &common);
    return true;
  }

  void arrange(const SparseMatrix& matrix) {
    const auto n = static_cast<int>(order.size());
    std::vector<int> place(order.size());
    for (int k = 0; k < n; ++k) place[order[k]] = k;
    const auto for_each_lower = [&](const auto& visit) {
      for (int c = 0; c < n; ++c)
        for (int k = matrix.outerIndexPtr()[c]; k < matrix.outerIndexPtr()[c + 1]; ++k)
          if (const int r = matrix.innerIndexPtr()[k]; r >= c)
            visit(std::max(place[r], place[c]), std::min(place[r], place[c]), k);
    };
    begin.assign(1, 0);
    begin.resize(place.size() + 1, 0);
    for_each_lower([&](int, int column, int) { ++begin[column + 1]; });
    for (int c = 0; c < n; ++c) begin[c + 1] += begin[c];
    std::vector<std::pair<int, int>> entries(static_cast<std::size_t>(begin.back()));
    std::vector<int> next = begin;
    for_each_lower([&](int row, int column, int k) { entries[next[column]++] = {row, k}; });
    for (int c = 0; c < n; ++c) std::sort(entries.begin() + begin[c], entries.begin() + begin[c + 1]);
    for (const auto& [row, k] : entries) {
      rows.push_back(row);
      from.push_back(k);
    }
  }

  Common common_;
  cholmod_factor* symbolic_ = nullptr;
};

class CholmodSolver final : public SparseSolver, public CopiedSolver {
 public:
  CholmodSolver() = default;
  ~CholmodSolver() override {
    if (factor_) cholmod_free_factor(&factor_, &common_.cholmod);
    for (cholmod_dense** room : {&x_, &y_, &e_})
      if (*room) cholmod_free_dense(room, &common_.cholmod);
  }
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  bool factor(const SparseMatrix& matrix) override {
    const OneThread one_thread;
    if (pattern_.changes_to(matrix) || !analysis_) {
      analysis_ = std::make_shared<const Analysis>(matrix);
      copy_analysis();
    }
    if (!factor_) return false;
    values_.resize(analysis_->from.size());
    for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = matrix.valuePtr()[analysis_->from[k]];
    cholmod_sparse view = analysis_->lower(values_);
    cholmod_factorize(&view, factor_, &common_.cholmod);
    return common_.cholmod.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  MatrixX solve(const MatrixX& rhs) const override {
    const OneThread one_thread;
    const std::vector<int>& order = analysis_->order;
    const MatrixX ordered = rhs(order, Eigen::all);
    cholmod_dense b{};
    b.nrow = b.d = static_cast<size_t>(rhs.rows());
    b.ncol = static_cast<size_t>(rhs.cols());
    b.nzmax = b.nrow * b.ncol;
    b.x = const_cast<double*>(ordered.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_A, factor_, &b, nullptr, &x_, nullptr, &y_, &e_, &common_.cholmod);
    MatrixX out(rhs.rows(), rhs.cols());
    out(order, Eigen::all) = Eigen::Map<MatrixX>(static_cast<double*>(x_->x), rhs.rows(), rhs.cols());
    return out;
  }

  void take_analysis(const SparseSolver& other) override {
    const auto& o = dynamic_cast<const CholmodSolver&>(other);
    if (!o.analysis_) return;
    const OneThread one_thread;
    pattern_ = o.pattern_;
    analysis_ = o.analysis_;
    copy_analysis();
  }

  std::unique_ptr<SparseSolver> copy() const override {
    auto out = std::make_unique<CholmodSolver>();
    out->pattern_ = pattern_;
    out->analysis_ = analysis_;
    const OneThread one_thread;
    if (factor_) out->factor_ = cholmod_copy_factor(factor_, &out->common_.cholmod);
    return out;
  }

 private:
  void copy_analysis() {
    if (factor_) cholmod_free_factor(&factor_, &common_.cholmod);
    factor_ = analysis_->copy(common_);
  }
  mutable Common common_;
  std::shared_ptr<const Analysis> analysis_;
  cholmod_factor* factor_ = nullptr;
  std::vector<double> values_;                                        // of the lower triangle in the factor's order
  mutable cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;  // room, as large each time
  SparsityPattern pattern_;                                           // of analysis_
};

}  // namespace

std::unique_ptr<SparseSolver> make_cholmod_solver() { return std::make_unique<CholmodSolver>(); }

}  // namespace kt
