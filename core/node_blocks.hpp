#pragma once
// Stiffness, damping and mass of the free nodes as symmetric 3 x 3 blocks, one for every two neighbours: half the memory
// of sparse matrices, and products with several vectors at once go through it at the speed of memory.
#include "core/free_dofs.hpp"
#include "core/tangent_model.hpp"

namespace kt {

template <int M>
using NodeRows = Eigen::Matrix<double, Eigen::Dynamic, M, M == 1 ? Eigen::ColMajor : Eigen::RowMajor>;  ///< (3 free x M)

class NodeBlocks {
 public:
  static constexpr int kSize = 18;  ///< numbers of a pair of blocks: stiffness, then damping, column by column

  /// The symmetric parts of -dfdx and -dfdv on the free nodes. A body's matrices always have the same pattern and mass,
  /// which are taken over at the first call (and when the numbers of entries change).
  void update(const TangentModel& tangent, const FreeDofs& dofs);

  int num_nodes() const { return static_cast<int>(begin_.size()) - 1; }
  /// Neighbours of free node j, itself among them, ascending: neighbour(k) for k = first(j) .. last(j) - 1.
  int first(int j) const { return around_begin_[j]; }
  int last(int j) const { return around_begin_[j + 1]; }
  int neighbour(int k) const { return around_[k]; }
  /// Which pair of blocks joins neighbour(k) and j, the row of the one with the higher number.
  int block(int k) const { return around_block_[k]; }
  int diagonal(int j) const { return begin_[j]; }
  const std::vector<double>& values() const { return values_; }
  const std::vector<double>& mass_values() const { return mass_; }  ///< nine a block

  /// out = K u, D u, M u.
  template <int M>
  void stiffness(const NodeRows<M>& u, NodeRows<M>& out) const { multiply<kSize>(values_.data(), u, out); }
  template <int M>
  void damping(const NodeRows<M>& u, NodeRows<M>& out) const { multiply<kSize>(values_.data() + 9, u, out); }
  template <int M>
  void mass(const NodeRows<M>& u, NodeRows<M>& out) const;

 private:
  void make_pattern(const TangentModel& tangent, const FreeDofs& dofs);
  template <int Size, int M>
  void multiply(const double* values, const NodeRows<M>& u, NodeRows<M>& out) const;
  std::vector<int> begin_, rows_;  // lower blocks of each column, the diagonal first
  std::vector<double> values_, mass_;
  bool lumped_ = false;  // mass only on the diagonal of the matrix
  std::vector<int> around_begin_, around_, around_block_;
  std::array<std::vector<int>, 2> slots_;  // of dfdx's and dfdv's entries in values_, -1: fixed
  std::array<Eigen::Index, 2> entries_{-1, -1};
};

template <int Size, int M>
void NodeBlocks::multiply(const double* values, const NodeRows<M>& u, NodeRows<M>& out) const {
  out.setZero(u.rows(), M);
  for (int j = 0; j < num_nodes(); ++j) {
    const double* uj = u.data() + static_cast<std::ptrdiff_t>(3 * M) * j;
    double* oj = out.data() + static_cast<std::ptrdiff_t>(3 * M) * j;
    double sum[3 * M] = {};
    for (int k = begin_[j]; k < begin_[j + 1]; ++k) {
      const double* b = values + static_cast<std::ptrdiff_t>(Size) * k;
      const double* ui = u.data() + static_cast<std::ptrdiff_t>(3 * M) * rows_[k];
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          for (int m = 0; m < M; ++m) sum[M * c + m] += b[3 * c + r] * ui[M * r + m];
      if (k == begin_[j]) continue;
      double* oi = out.data() + static_cast<std::ptrdiff_t>(3 * M) * rows_[k];
      for (int r = 0; r < 3; ++r)
        for (int m = 0; m < M; ++m)
          oi[M * r + m] += b[r] * uj[m] + b[3 + r] * uj[M + m] + b[6 + r] * uj[2 * M + m];
    }
    for (int m = 0; m < 3 * M; ++m) oj[m] += sum[m];
  }
}

template <int M>
void NodeBlocks::mass(const NodeRows<M>& u, NodeRows<M>& out) const {
  if (!lumped_) {
    multiply<9>(mass_.data(), u, out);
    return;
  }
  out.resize(u.rows(), M);
  for (int j = 0; j < num_nodes(); ++j)
    for (int c = 0; c < 3; ++c) out.row(3 * j + c) = mass_[9 * static_cast<std::size_t>(begin_[j]) + 4 * c] * u.row(3 * j + c);
}

}  // namespace kt
