#include "core/panel_product.hpp"

#include <algorithm>

#include "core/wide.hpp"

namespace kt {
namespace {

constexpr int kRows = PanelMatrix::kRows;

template <int Width, class Stored>
KT_INLINE void sum_panel_in(const Stored* panel, const double* x, std::ptrdiff_t cols, double* out) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  typedef Stored Narrow __attribute__((vector_size(sizeof(Stored) * Width)));
  constexpr int kSums = 4;  // with two of each: eight sums that do not wait for one another, in any width
  const auto read = [&](std::ptrdiff_t column, int row, Lanes& into) {
    Narrow stored;
    __builtin_memcpy(&stored, panel + column * kRows + row, sizeof stored);
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
    if constexpr (Width == 8 && sizeof(Stored) == sizeof(float)) {  // GCC makes two halves of it
      asm("vcvtps2pd %1, %0" : "=v"(into) : "vm"(stored));
      return;
    }
#endif
    into = __builtin_convertvector(stored, Lanes);
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

template <int Width>
KT_INLINE void sum_doubles_in(const double* panel, const double* x, std::ptrdiff_t cols, double* out) {
  sum_panel_in<Width>(panel, x, cols, out);
}
template <int Width>
KT_INLINE void sum_floats_in(const float* panel, const double* x, std::ptrdiff_t cols, double* out) {
  sum_panel_in<Width>(panel, x, cols, out);
}
KT_WIDTHS(sum_doubles, (const double* panel, const double* x, std::ptrdiff_t cols, double* out), (panel, x, cols, out))
KT_WIDTHS(sum_floats, (const float* panel, const double* x, std::ptrdiff_t cols, double* out), (panel, x, cols, out))

template <class Stored>
std::vector<Stored> in_panels(const Eigen::Ref<const MatrixX>& matrix) {
  const Eigen::Index panels = (matrix.rows() + kRows - 1) / kRows;
  std::vector<Stored> out(static_cast<std::size_t>(panels * kRows * matrix.cols()));
  for (Eigen::Index j = 0; j < matrix.cols(); ++j)
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      out[static_cast<std::size_t>((i / kRows * matrix.cols() + j) * kRows + i % kRows)] =
          static_cast<Stored>(matrix(i, j));
  return out;
}

}  // namespace

PanelMatrix::PanelMatrix(const Eigen::Ref<const MatrixX>& matrix, PanelStorage storage)
    : rows_(matrix.rows()), cols_(matrix.cols()) {
  if (storage == PanelStorage::in_float)
    singles_ = in_panels<float>(matrix);
  else
    doubles_ = in_panels<double>(matrix);
}

void PanelMatrix::multiply(const VectorX& x, VectorX& out) const noexcept {
  if (out.size() != rows_) out.resize(rows_);
  double last[kRows];
  for (Eigen::Index i = 0; i < rows_; i += kRows) {
    const bool is_whole = i + kRows <= rows_;
    double* const to = is_whole ? out.data() + i : last;
    if (singles_.empty())
      sum_doubles(doubles_.data() + i * cols_, x.data(), cols_, to);
    else
      sum_floats(singles_.data() + i * cols_, x.data(), cols_, to);
    if (!is_whole) std::copy_n(last, rows_ - i, out.data() + i);
  }
}

}  // namespace kt
