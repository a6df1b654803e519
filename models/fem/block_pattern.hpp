#pragma once
// A fixed sparsity pattern of 3 x 3 node blocks, and sums into it. While being summed, the values of a node's three
// columns hold its blocks one after another, nine numbers each: one write to neighbouring places instead of three to
// distant ones. finish() puts them into their columns.
// Only blocks of different nodes are summed: forces within a body do not feel its position, so that every column (and
// row) sums to zero, and the diagonal block is minus the sum of the others.
#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/base/types.hpp"

namespace kt {

class BlockPattern {
 public:
  /// @param elements  containers of the nodes that each joins
  template <class Elements>
  BlockPattern(int num_nodes, const Elements& elements) {
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(num_nodes));
    for (const auto& element : elements)
      for (int a : element)
        for (int b : element) neighbours[a].push_back(b);
    begin_.push_back(0);
    for (int j = 0; j < num_nodes; ++j) {
      auto& rows = neighbours[j];
      rows.push_back(j);
      std::sort(rows.begin(), rows.end());
      rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
      rows_.insert(rows_.end(), rows.begin(), rows.end());
      begin_.push_back(static_cast<int>(rows_.size()));
    }
    if (9 * rows_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw InputError(text("fem: ", num_nodes, " nodes are too many: the stiffness would have ", 9 * rows_.size(),
                            " entries, at most ", std::numeric_limits<int>::max(), " can be counted"));
    make_zero();
    mirror_.resize(rows_.size());
    for (int j = 0; j < num_nodes; ++j) {
      diagonal_.push_back(block(j, j) - begin_[j]);
      for (int k = begin_[j]; k < begin_[j + 1]; ++k) mirror_[k] = block(j, rows_[k]);
    }
  }

  /// The pattern with all values zero.
  const SparseMatrix& zero() const { return zero_; }
  /// Index of the block of two nodes that share an element.
  int block(int row, int column) const {
    const auto begin = rows_.begin() + begin_[column], end = rows_.begin() + begin_[column + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
  }
  /// Place of an entry among the values of a matrix with this pattern.
  int slot(int row, int column) const {
    const int j = column / 3, k = block(row / 3, j) - begin_[j];
    return 9 * begin_[j] + 3 * (count(j) * (column % 3) + k) + row % 3;
  }
  int mirrored(int block) const { return mirror_[block]; }
  /// Where to add the nine numbers, column by column, of a block of `sum`.
  static double* values_of(SparseMatrix& sum, int block) { return sum.valuePtr() + 9 * block; }

  /// Before summing: `sum` gets this pattern, if it has another (judged by its size and number of entries), and its
  /// blocks above the diagonal, or all, are zero.
  void start(SparseMatrix& sum, bool symmetric) const {
    if (sum.rows() != zero_.rows() || sum.nonZeros() != zero_.nonZeros()) {
      sum = zero_;
      return;
    }
    for_each_column([&](int j) {
      double* column = values_of(sum, begin_[j]);
      std::fill(column, column + 9 * (symmetric ? diagonal_[j] : count(j)), 0.0);
    });
  }
  /// Sum of blocks -> matrix. `symmetric`: only blocks with row < column were summed, the others are their mirrors.
  void finish(SparseMatrix& sum, bool symmetric) const {
    for_each_column([&](int j) { spread(sum, j, symmetric); });
    for_each_column([&](int j) {
      if (symmetric) mirror_into(sum, j);
      close(sum, j);
    });
  }

 private:
  void make_zero() {
    const int nodes = static_cast<int>(begin_.size()) - 1;
    std::vector<int> outer{0}, inner;
    for (int j = 0; j < nodes; ++j)
      for (int c = 0; c < 3; ++c) {
        for (int k = begin_[j]; k < begin_[j + 1]; ++k)
          inner.insert(inner.end(), {3 * rows_[k], 3 * rows_[k] + 1, 3 * rows_[k] + 2});
        outer.push_back(static_cast<int>(inner.size()));
      }
    const std::vector<double> values(inner.size(), 0.0);
    zero_ = Eigen::Map<const SparseMatrix>(3 * nodes, 3 * nodes, static_cast<Eigen::Index>(inner.size()), outer.data(),
                                           inner.data(), values.data());
  }

  template <class Work>
  void for_each_column(const Work& work) const {
    constexpr int kChunk = 512;  // nodes a task
    const int nodes = static_cast<int>(begin_.size()) - 1;
    parallel_for((nodes + kChunk - 1) / kChunk, [&](int i) {
      for (int j = i * kChunk; j < std::min(nodes, (i + 1) * kChunk); ++j) work(j);
    });
  }

  int count(int j) const { return begin_[j + 1] - begin_[j]; }

  void spread(SparseMatrix& sum, int j, bool symmetric) const {
    const int height = 3 * count(j), filled = symmetric ? diagonal_[j] : count(j);
    double* column = values_of(sum, begin_[j]);
    thread_local std::vector<double> blocks;
    blocks.assign(column, column + 9 * filled);
    const double* block = blocks.data();
    for (int k = 0; k < filled; ++k, block += 9)
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) column[height * c + 3 * k + r] = block[3 * c + r];
  }

  void mirror_into(SparseMatrix& sum, int j) const {
    const int height = 3 * count(j);
    double* column = values_of(sum, begin_[j]);
    for (int k = diagonal_[j] + 1; k < count(j); ++k) {
      const int i = rows_[begin_[j] + k], from_height = 3 * count(i);
      const double* from = values_of(sum, begin_[i]) + 3 * (mirror_[begin_[j] + k] - begin_[i]);
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) column[height * c + 3 * k + r] = from[from_height * r + c];
    }
  }

  void close(SparseMatrix& sum, int j) const {
    const int height = 3 * count(j);
    double* column = values_of(sum, begin_[j]);
    double others[9] = {};
    for (int k = 0; k < count(j); ++k) {
      if (k == diagonal_[j]) continue;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) others[3 * c + r] += column[height * c + 3 * k + r];
    }
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) column[height * c + 3 * diagonal_[j] + r] = -others[3 * c + r];
  }

  SparseMatrix zero_;
  std::vector<int> begin_, rows_;  // blocks of each node column, by ascending row
  std::vector<int> mirror_;        // of block (i, j): block (j, i)
  std::vector<int> diagonal_;      // which block of each column is (j, j)
};

}  // namespace kt
