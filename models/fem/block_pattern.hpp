#pragma once
// A fixed sparsity pattern of 3 x 3 node blocks, and where each element's blocks lie in it: assembly without searching.
#include <algorithm>
#include <vector>

#include "core/types.hpp"

namespace kt {

template <int N>
class BlockPattern {
 public:
  BlockPattern(int num_nodes, const std::vector<std::array<int, N>>& elements) {
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(num_nodes));
    for (const auto& element : elements)
      for (int a : element)
        for (int b : element) neighbours[a].push_back(b);
    zero_.resize(3 * num_nodes, 3 * num_nodes);
    for (int i = 0; i < num_nodes; ++i) {
      auto& rows = neighbours[i];
      rows.push_back(i);
      std::sort(rows.begin(), rows.end());
      rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    }
    Eigen::VectorXi per_column(3 * num_nodes);
    for (int i = 0; i < 3 * num_nodes; ++i) per_column[i] = static_cast<int>(3 * neighbours[i / 3].size());
    zero_.reserve(per_column);
    for (int i = 0; i < 3 * num_nodes; ++i)
      for (int row : neighbours[i / 3])
        for (int r = 0; r < 3; ++r) zero_.insert(3 * row + r, i) = 0;
    zero_.makeCompressed();

    height_.resize(static_cast<std::size_t>(num_nodes));
    for (int i = 0; i < num_nodes; ++i) height_[i] = static_cast<int>(3 * neighbours[i].size());
    nodes_ = elements;
    slots_.reserve(elements.size());
    for (const auto& element : elements) {
      std::array<int, N * N> slots;
      for (int b = 0; b < N; ++b)
        for (int a = 0; a < N; ++a) {
          const auto& rows = neighbours[element[b]];
          const auto at = std::lower_bound(rows.begin(), rows.end(), element[a]) - rows.begin();
          slots[N * b + a] = zero_.outerIndexPtr()[3 * element[b]] + static_cast<int>(3 * at);
        }
      slots_.push_back(slots);
    }
  }

  /// The pattern with all values zero.
  const SparseMatrix& zero() const { return zero_; }

  /// Adds an element's (3N x 3N) matrix to one with this pattern.
  void add(SparseMatrix& out, std::size_t element, const Eigen::Matrix<double, 3 * N, 3 * N>& m) const {
    double* values = out.valuePtr();
    for (int b = 0; b < N; ++b) {
      const int height = height_[nodes_[element][b]];
      for (int a = 0; a < N; ++a) {
        double* block = values + slots_[element][N * b + a];
        for (int c = 0; c < 3; ++c, block += height)
          for (int r = 0; r < 3; ++r) block[r] += m(3 * a + r, 3 * b + c);
      }
    }
  }

 private:
  SparseMatrix zero_;
  std::vector<int> height_;  // entries of one column of a node
  std::vector<std::array<int, N>> nodes_;
  std::vector<std::array<int, N * N>> slots_;  // first entry of block (a, b) at N b + a
};

}  // namespace kt
