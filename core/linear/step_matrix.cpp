#include "core/linear/step_matrix.hpp"

#include <algorithm>

#include "core/base/parallel.hpp"
#include "core/base/wide.hpp"
#include "core/linear/sparse_product.hpp"

namespace kt {

void StepMatrix::make_pattern(const std::array<MatrixTerm, 3>& terms) {
  const int nodes = dofs_.size() / 3;
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(nodes));  // node rows of each node column
  for (int i = 0; i < nodes; ++i) rows[i].push_back(i);
  for (const MatrixTerm& term : terms)
    for (int c = 0; c < term.matrix->outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(*term.matrix, c); it; ++it)
        if (const int i = dofs_.to_free[it.row()], j = dofs_.to_free[c]; i >= 0 && j >= 0) {
          auto& column = rows[j / 3];
          if (column.back() != i / 3) column.push_back(i / 3);
        }
  std::vector<int> outer{0}, inner;
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    for (int c = 0; c < 3; ++c) {
      for (int row : column) inner.insert(inner.end(), {3 * row, 3 * row + 1, 3 * row + 2});
      outer.push_back(static_cast<int>(inner.size()));
    }
  }
  const std::vector<double> zeros(inner.size(), 0.0);
  sum_ = Eigen::Map<const SparseMatrix>(dofs_.size(), dofs_.size(), static_cast<Eigen::Index>(inner.size()),
                                        outer.data(), inner.data(), zeros.data());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const SparseMatrix& term = *terms[t].matrix;
    in_blocks_[t] = term.rows() > 0 && has_node_blocks(term);
    runs_[t].clear();
    for (int c = 0; c < term.outerSize(); ++c) {
      const int j = dofs_.to_free[c];
      if (j < 0) continue;
      for (int k = term.outerIndexPtr()[c]; k < term.outerIndexPtr()[c + 1]; ++k) {
        const int i = dofs_.to_free[term.innerIndexPtr()[k]];
        if (i < 0) continue;
        const auto begin = inner.begin() + outer[j], end = inner.begin() + outer[j + 1];
        const int to = static_cast<int>(std::lower_bound(begin, end, i) - inner.begin());
        Run* const last = runs_[t].empty() ? nullptr : &runs_[t].back();
        if (last && last->from + last->length == k && last->to + last->length == to)
          ++last->length;
        else
          runs_[t].push_back({k, to, 1});
      }
    }
  }
}

namespace {

KT_WIDE void add_run(double factor, const double* from, double* __restrict to, int length) {
  for (int k = 0; k < length; ++k) to[k] += factor * from[k];
}

}  // namespace

const SparseMatrix& StepMatrix::sum(const std::array<MatrixTerm, 3>& terms) {
  bool changed = false;
  for (std::size_t t = 0; t < terms.size(); ++t) changed |= patterns_[t].changes_to(*terms[t].matrix);
  if (changed) make_pattern(terms);
  double* out = sum_.valuePtr();
  std::fill(out, out + sum_.nonZeros(), 0.0);
  constexpr int kChunk = 1 << 12;  // runs a task
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const int n = static_cast<int>(runs_[t].size());
    const double* from = terms[t].matrix->valuePtr();
    parallel_for((n + kChunk - 1) / kChunk, [&](int chunk) {
      for (int k = chunk * kChunk; k < std::min(n, (chunk + 1) * kChunk); ++k) {
        const Run& run = runs_[t][k];
        add_run(terms[t].factor, from + run.from, out + run.to, run.length);
      }
    });
  }
  return sum_;
}

bool StepMatrix::add(double factor, const std::vector<Eigen::Triplet<double>>& entries) {
  std::vector<std::pair<int, double>> found;
  for (const auto& entry : entries) {
    const int i = dofs_.to_free[entry.row()], j = dofs_.to_free[entry.col()];
    if (i < 0 || j < 0) continue;
    const int *const rows = sum_.innerIndexPtr(), *const end = rows + sum_.outerIndexPtr()[j + 1];
    const int* const at = std::lower_bound(rows + sum_.outerIndexPtr()[j], end, i);
    if (at == end || *at != i) return false;
    found.emplace_back(static_cast<int>(at - rows), factor * entry.value());
  }
  for (const auto& [to, value] : found) sum_.valuePtr()[to] += value;
  return true;
}

std::vector<Eigen::Triplet<double>> StepMatrix::of_free_nodes(
    double factor, const std::vector<Eigen::Triplet<double>>& entries) const {
  std::vector<Eigen::Triplet<double>> out;
  for (const auto& entry : entries)
    if (const int i = dofs_.to_free[entry.row()], j = dofs_.to_free[entry.col()]; i >= 0 && j >= 0)
      out.emplace_back(i, j, factor * entry.value());
  return out;
}

VectorX StepMatrix::symmetric_times(std::size_t term, const SparseMatrix& matrix, const VectorX& x) const {
  if (matrix.rows() == 0) return VectorX::Zero(dofs_.size());
  return gather(dofs_, in_blocks_[term] ? symmetric_blocks_times(matrix, x) : VectorX(matrix * x));
}

}  // namespace kt
