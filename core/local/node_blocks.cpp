#include "core/local/node_blocks.hpp"

#include <algorithm>

#include "core/base/wide.hpp"
#include "core/linear/sparse_product.hpp"

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
    places_[m] = {};
    const int step = has_node_blocks(matrix) ? 3 : 1;
    for (int c = 0; c < matrix.outerSize(); ++c)
      for (int k = matrix.outerIndexPtr()[c]; k < matrix.outerIndexPtr()[c + 1]; k += step) {
        const int row = matrix.innerIndexPtr()[k];
        const auto at = place(row, c);
        if (at < 0) continue;
        auto& list = step == 1 ? places_[m].others : row / 3 < c / 3 ? places_[m].rows : places_[m].columns;
        list.push_back({k, static_cast<int>(2 * at - at % 9 + static_cast<std::ptrdiff_t>(9 * m))});
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

bool NodeBlocks::update(const TangentModel& tangent, const FreeDofs& dofs) {
  // Both are asked: each remembers what it is shown.
  const bool dfdx_changes = patterns_[0].changes_to(tangent.dfdx), dfdv_changes = patterns_[1].changes_to(tangent.dfdv);
  const bool changes = dfdx_changes || dfdv_changes || num_nodes() != dofs.size() / 3;
  if (changes) make_pattern(tangent, dofs);
  std::fill(values_.begin(), values_.end(), 0.0);
  for (std::size_t m = 0; m < 2; ++m) {
    const double* from = (m == 0 ? tangent.dfdx : tangent.dfdv).valuePtr();
    for (auto [k, to] : places_[m].columns)
      for (int i = 0; i < 3; ++i) values_[to + i] -= 0.5 * from[k + i];
    for (auto [k, to] : places_[m].rows)
      for (int i = 0; i < 3; ++i) values_[to + 3 * i] -= 0.5 * from[k + i];
    for (auto [k, to] : places_[m].others) values_[to] -= 0.5 * from[k];
  }
  // Blocks off the diagonal have got both halves; one on it is still to be added to its transpose.
  for (int j = 0; j < num_nodes(); ++j)
    for (int m = 0; m < 2; ++m) {
      Eigen::Map<Mat3> d(values_.data() + kSize * static_cast<std::size_t>(begin_[j]) + 9 * m);
      d = (d + d.transpose()).eval();
    }
  return changes;
}

namespace {

/// The lower blocks of a symmetric matrix (nine numbers at the beginning of every `size`), its columns and rows.
struct LowerBlocks {
  const double* values;
  std::ptrdiff_t size;
  const int *begin, *rows;
  int nodes;
};

/// For `Count` matrices side by side, nine numbers after one another.
template <int M, int Count>
inline __attribute__((always_inline)) void multiply(const LowerBlocks& a, const double* u, double* const* out) {
  for (int j = 0; j < a.nodes; ++j) {
    const double* uj = u + static_cast<std::ptrdiff_t>(3 * M) * j;
    double sum[Count][3 * M] = {};
    for (int k = a.begin[j]; k < a.begin[j + 1]; ++k) {
      const double* ui = u + static_cast<std::ptrdiff_t>(3 * M) * a.rows[k];
      for (int n = 0; n < Count; ++n) {
        const double* b = a.values + a.size * k + 9 * n;
        for (int c = 0; c < 3; ++c)
          for (int m = 0; m < M; ++m)
            sum[n][M * c + m] += b[3 * c] * ui[m] + b[3 * c + 1] * ui[M + m] + b[3 * c + 2] * ui[2 * M + m];
        if (k == a.begin[j]) continue;
        double* oi = out[n] + static_cast<std::ptrdiff_t>(3 * M) * a.rows[k];
        for (int r = 0; r < 3; ++r)
          for (int m = 0; m < M; ++m) oi[M * r + m] += b[r] * uj[m] + b[3 + r] * uj[M + m] + b[6 + r] * uj[2 * M + m];
      }
    }
    for (int n = 0; n < Count; ++n) {
      double* oj = out[n] + static_cast<std::ptrdiff_t>(3 * M) * j;
      for (int m = 0; m < 3 * M; ++m) oj[m] += sum[n][m];
    }
  }
}

KT_WIDE void multiply_6(const LowerBlocks& a, const double* u, double* const* out) { multiply<6, 1>(a, u, out); }
KT_WIDE void multiply_12(const LowerBlocks& a, const double* u, double* const* out) { multiply<12, 1>(a, u, out); }
KT_WIDE void multiply_24(const LowerBlocks& a, const double* u, double* const* out) { multiply<24, 1>(a, u, out); }
KT_WIDE void multiply_both_6(const LowerBlocks& a, const double* u, double* const* out) { multiply<6, 2>(a, u, out); }
KT_WIDE void multiply_both_24(const LowerBlocks& a, const double* u, double* const* out) { multiply<24, 2>(a, u, out); }

template <int M>
void multiply_rows(const LowerBlocks& a, const NodeRows<M>& u, NodeRows<M>& out) {
  out.setZero(u.rows(), M);
  double* const outs[]{out.data()};
  if constexpr (M == 6) multiply_6(a, u.data(), outs);
  if constexpr (M == 12) multiply_12(a, u.data(), outs);
  if constexpr (M == 24) multiply_24(a, u.data(), outs);
}

}  // namespace

template <int M>
void NodeBlocks::stiffness(const NodeRows<M>& u, NodeRows<M>& out) const {
  multiply_rows<M>({values_.data(), kSize, begin_.data(), rows_.data(), num_nodes()}, u, out);
}

template <int M>
void NodeBlocks::stiffness_and_damping(const NodeRows<M>& u, NodeRows<M>& forces, NodeRows<M>& damped) const {
  forces.setZero(u.rows(), M);
  damped.setZero(u.rows(), M);
  const LowerBlocks both{values_.data(), kSize, begin_.data(), rows_.data(), num_nodes()};
  double* const outs[]{forces.data(), damped.data()};
  M == 6 ? multiply_both_6(both, u.data(), outs) : multiply_both_24(both, u.data(), outs);
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

template void NodeBlocks::stiffness<12>(const NodeRows<12>&, NodeRows<12>&) const;
template void NodeBlocks::stiffness_and_damping<6>(const NodeRows<6>&, NodeRows<6>&, NodeRows<6>&) const;
template void NodeBlocks::stiffness_and_damping<24>(const NodeRows<24>&, NodeRows<24>&, NodeRows<24>&) const;
template void NodeBlocks::mass<6>(const NodeRows<6>&, NodeRows<6>&) const;
template void NodeBlocks::mass<12>(const NodeRows<12>&, NodeRows<12>&) const;
template void NodeBlocks::mass<24>(const NodeRows<24>&, NodeRows<24>&) const;

}  // namespace kt
