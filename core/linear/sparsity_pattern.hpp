#pragma once
// Remembers where a matrix has entries, so that a symbolic analysis is reused only for the pattern it was made for.
#include <algorithm>
#include <span>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

class SparsityPattern {
 public:
  /// True when `matrix` (compressed) has another pattern than the one before; remembers it.
  bool changes_to(const SparseMatrix& matrix) {
    const std::span<const int> columns(matrix.outerIndexPtr(), static_cast<std::size_t>(matrix.outerSize()) + 1);
    const std::span<const int> rows(matrix.innerIndexPtr(), static_cast<std::size_t>(matrix.nonZeros()));
    if (std::ranges::equal(columns, columns_) && std::ranges::equal(rows, rows_)) return false;
    columns_.assign(columns.begin(), columns.end());
    rows_.assign(rows.begin(), rows.end());
    return true;
  }

 private:
  std::vector<int> columns_, rows_;
};

}  // namespace kt
