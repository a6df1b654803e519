#include "core/step_matrix.hpp"

#include <algorithm>

#include "core/parallel.hpp"

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
    slots_[t].clear();
    for (int c = 0; c < terms[t].matrix->outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(*terms[t].matrix, c); it; ++it) {
        const int i = dofs_.to_free[it.row()], j = dofs_.to_free[c];
        if (i < 0 || j < 0) {
          slots_[t].push_back(-1);
          continue;
        }
        const auto begin = inner.begin() + outer[j], end = inner.begin() + outer[j + 1];
        slots_[t].push_back(static_cast<int>(std::lower_bound(begin, end, i) - inner.begin()));
      }
  }
}

const SparseMatrix& StepMatrix::sum(const std::array<MatrixTerm, 3>& terms) {
  bool changed = false;
  for (std::size_t t = 0; t < terms.size(); ++t) changed |= patterns_[t].changes_to(*terms[t].matrix);
  if (changed) make_pattern(terms);
  double* out = sum_.valuePtr();
  std::fill(out, out + sum_.nonZeros(), 0.0);
  constexpr int kChunk = 1 << 16;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const int n = static_cast<int>(slots_[t].size());
    const double* from = terms[t].matrix->valuePtr();
    const int* to = slots_[t].data();
    const double factor = terms[t].factor;
    parallel_for((n + kChunk - 1) / kChunk, [&](int chunk) {
      for (int k = chunk * kChunk; k < std::min(n, (chunk + 1) * kChunk); ++k)
        if (to[k] >= 0) out[to[k]] += factor * from[k];
    });
  }
  return sum_;
}

}  // namespace kt
