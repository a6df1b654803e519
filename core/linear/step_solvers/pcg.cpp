// Conjugate gradients from the last solution. The preconditioner adds two levels: the inverse of every node's own 3 x 3
// block, for what changes from node to node; and a coarse problem in which groups of nodes move as rigid bodies
// (core/linear/coarse_space.hpp). The coarse matrix of an earlier step serves until the iterations show that it has
// aged.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.hpp"
#include "core/linear/coarse_space.hpp"
#include "core/linear/sparsity_pattern.hpp"
#include "core/linear/step_solver.hpp"
#include "core/linear/step_solvers/pcg_sweeps.hpp"

namespace kt {
namespace {

class ConjugateGradients final : public StepSolver {
 public:
  explicit ConjugateGradients(StepSolverOptions options) : options_(std::move(options)) {}

  bool solve(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    if (!prepare(matrix) || !iterate(rhs, x, options_.tolerance)) return false;
    if (fresh_iterations_ == 0) fresh_iterations_ = std::max(1, iterations_);
    aged_ = iterations_ > fresh_iterations_ + fresh_iterations_ / 4 + 2;
    return true;
  }
  /// How the coarse matrix ages shows in solutions of one accuracy: not in these.
  bool solve_roughly(const SparseMatrix& matrix, const VectorX& rhs, VectorX& x) override {
    return prepare(matrix) && iterate(rhs, x, std::max(kRough, options_.tolerance));
  }
  void put_beside(const MatrixEntries& entries) override { beside_ = entries; }
  int iterations() const override { return iterations_; }

 private:
  static constexpr double kRough = 1e-3;

  bool prepare(const SparseMatrix& matrix) {
    const bool is_new = pattern_.changes_to(matrix);
    if (is_new) make_room(matrix);
    matrix_.update(matrix);
    if (!invert_blocks()) return false;
    find_lanes_of_beside();
    if (is_new || aged_) {
      if (!coarse_->update(matrix)) return false;
      fresh_iterations_ = 0;
      aged_ = false;
    }
    return true;
  }

  void make_room(const SparseMatrix& matrix) {
    coarse_ = std::make_unique<CoarseSpace>(matrix, options_.positions);
    matrix_.set_pattern(matrix, coarse_->members());
    const auto nodes = static_cast<std::size_t>(matrix_.num_nodes());
    inverse_.assign(3 * kLanes * nodes, 0);
    arms_.assign(kLanes * nodes, 0);
    for (std::size_t i = 0; i < nodes; ++i) Vec3::Map(arms_.data() + kLanes * i) = coarse_->arm(coarse_->members()[i]);
    lane_of_.resize(nodes);
    for (std::size_t i = 0; i < nodes; ++i)
      lane_of_[static_cast<std::size_t>(coarse_->members()[i])] = static_cast<int>(i);
    for (std::vector<double>* v : {&r_, &p_, &q_, &z_}) v->assign(kLanes * nodes, 0);
    loads_.setZero(6 * coarse_->num_groups());
    // Groups of kChunk nodes together, or a little more, are a task: sums are made chunk by chunk.
    const std::vector<int>& begin = coarse_->members_begin();
    chunks_.assign(1, 0);
    for (int g = 1; g <= coarse_->num_groups(); ++g)
      if (g == coarse_->num_groups() || begin[g] - begin[chunks_.back()] >= kChunk) chunks_.push_back(g);
    partial_.assign(2 * kLanes * (chunks_.size() - 1), 0);
  }

  /// work(first group, last, first node, last, room for sums); the same chunks with any number of threads.
  template <class Work>
  void for_each_chunk(const Work& work) {
    const int chunks = static_cast<int>(chunks_.size()) - 1;
    const std::vector<int>& begin = coarse_->members_begin();
    const auto run = [&](int i) {
      double* sums = partial_.data() + static_cast<std::ptrdiff_t>(2 * kLanes) * i;
      std::fill_n(sums, 2 * kLanes, 0.0);
      work(chunks_[i], chunks_[i + 1], begin[chunks_[i]], begin[chunks_[i + 1]], sums);
    };
    if (chunks <= kFewChunks)
      for (int i = 0; i < chunks; ++i) run(i);
    else
      parallel_for(chunks, run);
  }
  /// The first sum over the chunks, or the second.
  double sum(std::size_t which = 0) const {
    double out = 0;
    for (std::size_t i = kLanes * which; i < partial_.size(); i += 2 * kLanes)
      out += (partial_[i] + partial_[i + 1]) + (partial_[i + 2] + partial_[i + 3]);
    return out;
  }

  /// Of this solve alone.
  void find_lanes_of_beside() {
    lanes_beside_.clear();
    const auto lane = [&](int dof) { return kLanes * lane_of_[static_cast<std::size_t>(dof / 3)] + dof % 3; };
    for (const auto& entry : beside_) lanes_beside_.emplace_back(lane(entry.row()), lane(entry.col()), entry.value());
    beside_.clear();
  }

  bool invert_blocks() {
    for_each_chunk([&](int, int, int first, int last, double* sums) {
      for (int i = first; i < last; ++i) {
        const Mat3 block = matrix_.diagonal(i);
        const bool definite =
            block(0, 0) > 0 && block.topLeftCorner<2, 2>().determinant() > 0 && block.determinant() > 0;
        if (!definite) sums[0] = 1;
        const Mat3 inverse = block.inverse();
        for (int c = 0; c < 3; ++c)
          Vec3::Map(inverse_.data() + static_cast<std::ptrdiff_t>(kLanes) * (3 * i + c)) = inverse.col(c);
      }
    });
    return sum() == 0;
  }

  /// q = A p; returns p . q.
  double multiply(const std::vector<double>& p, std::vector<double>& q) {
    for_each_chunk(
        [&](int, int, int first, int last, double* sums) { matrix_.times(p.data(), q.data(), first, last, sums); });
    double out = sum();
    for (const auto& entry : lanes_beside_) {
      const double product = entry.value() * p[static_cast<std::size_t>(entry.col())];
      q[static_cast<std::size_t>(entry.row())] += product;
      out += product * p[static_cast<std::size_t>(entry.row())];
    }
    return out;
  }
  /// Goes by `step` along p and preconditions the residual; returns r . z. `rr`: r . r.
  double descend(const PcgVectors& v, double step, double& rr) {
    for_each_chunk(
        [&](int first, int last, int, int, double* sums) { pcg_descend(v, step, first, last, loads_.data(), sums); });
    rr = sum();
    return sum(1);
  }
  void turn(const PcgVectors& v, double share) {
    for_each_chunk([&](int first, int last, int, int, double*) { pcg_turn(v, share, first, last, motions_.data()); });
  }

  /// False: not positive definite, or not converging.
  bool iterate(const VectorX& rhs, VectorX& x, double tolerance) {
    const double enough = tolerance * tolerance * rhs.squaredNorm();
    if (x.size() != rhs.size()) x.setZero(rhs.size());
    matrix_.to_lanes(x, x_);
    matrix_.to_lanes(rhs, r_);
    multiply(x_, q_);
    std::fill(p_.begin(), p_.end(), 0.0);
    const PcgVectors v{x_.data(), r_.data(),       p_.data(),    q_.data(),
                       z_.data(), inverse_.data(), arms_.data(), coarse_->members_begin().data()};
    double rr = 0, rz_before = 1;
    double rz = descend(v, 1, rr);  // r = rhs - A x; p is still zero
    for (iterations_ = 0; !(rr <= enough); ++iterations_) {
      if (iterations_ == options_.most_iterations) return false;
      coarse_->solve(loads_, motions_);
      rz += loads_.dot(motions_);
      if (!(rz > 0)) return false;
      turn(v, iterations_ == 0 ? 0 : rz / rz_before);
      const double curvature = multiply(p_, q_);
      if (!(curvature > 0)) return false;
      rz_before = rz;
      rz = descend(v, rz / curvature, rr);
    }
    matrix_.from_lanes(x_, x);
    return true;
  }

  static constexpr int kChunk = 512, kFewChunks = 4;  // nodes a task; fewer tasks are not worth waking a thread

  StepSolverOptions options_;
  SparsityPattern pattern_;
  std::unique_ptr<CoarseSpace> coarse_;
  LaneMatrix matrix_;
  std::vector<double> inverse_, arms_;  // of each node: three columns of its block's; from its group's centre
  std::vector<double> x_, r_, p_, q_, z_;
  VectorX loads_, motions_;     // of the groups
  MatrixEntries beside_;        // of the next solve
  MatrixEntries lanes_beside_;  // of this one, by their places in the lanes
  std::vector<int> lane_of_;    // of each node
  std::vector<int> chunks_;     // first group of each
  std::vector<double> partial_;
  int iterations_ = 0;
  int fresh_iterations_ = 0;  // with the coarse matrix of the same step
  bool aged_ = false;
};

}  // namespace

std::unique_ptr<StepSolver> make_pcg_step_solver(StepSolverOptions options) {
  return std::make_unique<ConjugateGradients>(std::move(options));
}

}  // namespace kt
