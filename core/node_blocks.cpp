#include "core/node_blocks.hpp"

#include <algorithm>

#include "core/wide.hpp"

namespace kt {
namespace {

/// Rows of every node column, i >= j, the diagonal first.
std::vector<std::vector<int>> lower_graph(const TangentModel& tangent, const FreeDofs& dofs) {
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(dofs.size() / 3));
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) rows[i].push_back(i);
  for (const SparseMatrix* matrix : {&tangent.dfdx, &tangent.dfdv, &tangent.mass})
    for (int c = 0; c < matrix->outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(*matrix, c); it; ++it)
        if (const int i = dofs.to_free[it.row()] / 3, j = dofs.to_free[c] / 3;
            dofs.to_free[it.row()] >= 0 && dofs.to_free[c] >= 0)
          if (auto& column = rows[std::min(i, j)]; column.back() != std::max(i, j)) column.push_back(std::max(i, j));
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  }
  return rows;
}

}  // namespace

void NodeBlocks::make_pattern(const TangentModel& tangent, const FreeDofs& dofs) {
  const auto graph = lower_graph(tangent, dofs);
  const int nodes = static_cast<int>(graph.size());
  begin_ = {0};
  rows_.clear();
  for (const auto& column : graph) {
    rows_.insert(rows_.end(), column.begin(), column.end());
    begin_.push_back(static_cast<int>(rows_.size()));
  }
  values_.assign(kSize * rows_.size(), 0);
  std::vector<std::vector<std::pair<int, int>>> around(graph.size());
  for (int j = 0; j < nodes; ++j)
    for (int k = begin_[j]; k < begin_[j + 1]; ++k) {
      around[j].emplace_back(rows_[k], k);
      if (rows_[k] != j) around[rows_[k]].emplace_back(j, k);
    }
  around_begin_ = {0};
  around_.clear();
  around_block_.clear();
  for (auto& list : around) {
    std::sort(list.begin(), list.end());
    for (auto [i, k] : list) {
      around_.push_back(i);
      around_block_.push_back(k);
    }
    around_begin_.push_back(static_cast<int>(around_.size()));
  }
  /// Where an entry of a matrix goes, nine numbers a block.
  const auto place = [&](Eigen::Index r, int c) -> std::ptrdiff_t {
    int row = dofs.to_free[r], column = dofs.to_free[c];
    if (row < 0 || column < 0) return -1;
    if (row / 3 < column / 3) std::swap(row, column);
    const auto from = rows_.begin() + begin_[column / 3], to = rows_.begin() + begin_[column / 3 + 1];
    return 9 * (std::lower_bound(from, to, row / 3) - rows_.begin()) + 3 * (column % 3) + row % 3;
  };
  for (std::size_t m = 0; m < 2; ++m) {
    const SparseMatrix& matrix = m == 0 ? tangent.dfdx : tangent.dfdv;
    slots_[m].clear();
    for (int c = 0; c < matrix.outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(matrix, c); it; ++it) {
        const auto k = place(it.row(), c);
        slots_[m].push_back(k < 0 ? -1 : static_cast<int>(2 * k - k % 9 + static_cast<std::ptrdiff_t>(9 * m)));
      }
  }
  mass_.assign(9 * rows_.size(), 0);
  lumped_ = true;
  for (int c = 0; c < tangent.mass.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(tangent.mass, c); it; ++it)
      if (const auto k = place(it.row(), c); k >= 0) {
        mass_[static_cast<std::size_t>(k)] += it.row() / 3 == c / 3 ? it.value() : 0.5 * it.value();
        lumped_ &= it.row() == c;
      }
}

void NodeBlocks::update(const TangentModel& tangent, const FreeDofs& dofs) {
  const std::array<Eigen::Index, 2> entries{tangent.dfdx.nonZeros(), tangent.dfdv.nonZeros()};
  if (entries != entries_ || num_nodes() != dofs.size() / 3) {
    make_pattern(tangent, dofs);
    entries_ = entries;
  }
  std::fill(values_.begin(), values_.end(), 0.0);
  for (std::size_t m = 0; m < 2; ++m) {
    const double* from = (m == 0 ? tangent.dfdx : tangent.dfdv).valuePtr();
    for (std::size_t k = 0; k < slots_[m].size(); ++k)
      if (slots_[m][k] >= 0) values_[slots_[m][k]] -= 0.5 * from[k];
  }
  // Blocks off the diagonal have got both halves; one on it is still to be added to its transpose.
  for (int j = 0; j < num_nodes(); ++j)
    for (int m = 0; m < 2; ++m) {
      Eigen::Map<Mat3> d(values_.data() + kSize * static_cast<std::size_t>(begin_[j]) + 9 * m);
      d = (d + d.transpose()).eval();
    }
}

namespace {

/// The lower blocks of a symmetric matrix (nine numbers at the beginning of every `size`), its columns and rows.
struct LowerBlocks {
  const double* values;
  std::ptrdiff_t size;
  const int *begin, *rows;
  int nodes;
};

template <int M>
inline __attribute__((always_inline)) void multiply(const LowerBlocks& a, const double* u, double* out) {
  for (int j = 0; j < a.nodes; ++j) {
    const double* uj = u + static_cast<std::ptrdiff_t>(3 * M) * j;
    double sum[3 * M] = {};
    for (int k = a.begin[j]; k < a.begin[j + 1]; ++k) {
      const double* b = a.values + a.size * k;
      const double* ui = u + static_cast<std::ptrdiff_t>(3 * M) * a.rows[k];
      for (int c = 0; c < 3; ++c)
        for (int m = 0; m < M; ++m)
          sum[M * c + m] += b[3 * c] * ui[m] + b[3 * c + 1] * ui[M + m] + b[3 * c + 2] * ui[2 * M + m];
      if (k == a.begin[j]) continue;
      double* oi = out + static_cast<std::ptrdiff_t>(3 * M) * a.rows[k];
      for (int r = 0; r < 3; ++r)
        for (int m = 0; m < M; ++m) oi[M * r + m] += b[r] * uj[m] + b[3 + r] * uj[M + m] + b[6 + r] * uj[2 * M + m];
    }
    double* oj = out + static_cast<std::ptrdiff_t>(3 * M) * j;
    for (int m = 0; m < 3 * M; ++m) oj[m] += sum[m];
  }
}

KT_WIDE void multiply_1(const LowerBlocks& a, const double* u, double* out) { multiply<1>(a, u, out); }
KT_WIDE void multiply_6(const LowerBlocks& a, const double* u, double* out) { multiply<6>(a, u, out); }
KT_WIDE void multiply_18(const LowerBlocks& a, const double* u, double* out) { multiply<18>(a, u, out); }

template <int M>
void multiply_rows(const LowerBlocks& a, const NodeRows<M>& u, NodeRows<M>& out) {
  out.setZero(u.rows(), M);
  if constexpr (M == 1) multiply_1(a, u.data(), out.data());
  if constexpr (M == 6) multiply_6(a, u.data(), out.data());
  if constexpr (M == 18) multiply_18(a, u.data(), out.data());
}

}  // namespace

template <int M>
void NodeBlocks::stiffness(const NodeRows<M>& u, NodeRows<M>& out) const {
  multiply_rows<M>({values_.data(), kSize, begin_.data(), rows_.data(), num_nodes()}, u, out);
}

template <int M>
void NodeBlocks::damping(const NodeRows<M>& u, NodeRows<M>& out) const {
  multiply_rows<M>({values_.data() + 9, kSize, begin_.data(), rows_.data(), num_nodes()}, u, out);
}

template <int M>
void NodeBlocks::mass(const NodeRows<M>& u, NodeRows<M>& out) const {
  if (!lumped_) {
    multiply_rows<M>({mass_.data(), 9, begin_.data(), rows_.data(), num_nodes()}, u, out);
    return;
  }
  out.resize(u.rows(), M);
  for (int j = 0; j < num_nodes(); ++j)
    for (int c = 0; c < 3; ++c)
      out.row(3 * j + c) =
          mass_[9 * static_cast<std::size_t>(begin_[j]) + 4 * static_cast<std::size_t>(c)] * u.row(3 * j + c);
}

#define KT_NODE_BLOCKS(M)                                                         \
  template void NodeBlocks::stiffness<M>(const NodeRows<M>&, NodeRows<M>&) const; \
  template void NodeBlocks::damping<M>(const NodeRows<M>&, NodeRows<M>&) const;   \
  template void NodeBlocks::mass<M>(const NodeRows<M>&, NodeRows<M>&) const;
KT_NODE_BLOCKS(1)
KT_NODE_BLOCKS(6)
KT_NODE_BLOCKS(18)
#undef KT_NODE_BLOCKS

}  // namespace kt
