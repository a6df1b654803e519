#include "core/linear/dense/panel_product.hpp"

#include <algorithm>

#include "core/base/wide.hpp"

namespace kt {
namespace {

constexpr int kRows = PanelMatrix::kRows;

template <int Width>
KT_INLINE void sum_panel_in(const double* panel, const double* x, std::ptrdiff_t cols, double* out) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  constexpr int kSums = 4;  // with two of each: eight sums that do not wait for one another, in any width
  const auto read = [&](std::ptrdiff_t column, int row, Lanes& into) {
    __builtin_memcpy(&into, panel + column * kRows + row, sizeof into);
  };
  for (int row = 0; row < kRows; row += kSums * Width) {
    Lanes even[kSums] = {}, odd[kSums] = {}, a, b;
    std::ptrdiff_t k = 0;
    for (; k + 1 < cols; k += 2)
      for (int s = 0; s < kSums; ++s) {
        read(k, row + s * Width, a);
        read(k + 1, row + s * Width, b);
        even[s] += x[k] * a;
        odd[s] += x[k + 1] * b;
      }
    for (int s = 0; s < kSums && k < cols; ++s) {
      read(k, row + s * Width, a);
      even[s] += x[k] * a;
    }
    for (int s = 0; s < kSums; ++s) {
      const Lanes sum = even[s] + odd[s];
      __builtin_memcpy(out + row + s * Width, &sum, sizeof sum);
    }
  }
}

KT_WIDTHS(sum_panel, (const double* panel, const double* x, std::ptrdiff_t cols, double* out), (panel, x, cols, out))

}  // namespace

PanelMatrix::PanelMatrix(const Eigen::Ref<const MatrixX>& matrix) : rows_(matrix.rows()), cols_(matrix.cols()) {
  const Eigen::Index panels = (rows_ + kRows - 1) / kRows;
  values_.resize(static_cast<std::size_t>(panels * kRows * cols_));
  for (Eigen::Index j = 0; j < cols_; ++j)
    for (Eigen::Index i = 0; i < rows_; ++i)
      values_[static_cast<std::size_t>((i / kRows * cols_ + j) * kRows + i % kRows)] = matrix(i, j);
}

void PanelMatrix::multiply(const VectorX& x, VectorX& out) const noexcept {
  if (out.size() < rows_) out.resize(rows_);
  double last[kRows];
  for (Eigen::Index i = 0; i < rows_; i += kRows) {
    const bool is_whole = i + kRows <= rows_;
    double* const to = is_whole ? out.data() + i : last;
    sum_panel(values_.data() + i * cols_, x.data(), cols_, to);
    if (!is_whole) std::copy_n(last, rows_ - i, out.data() + i);
  }
}

}  // namespace kt
