#include "core/linear/dense/dense_product.hpp"

#include "core/base/wide.hpp"

namespace kt {
namespace {

constexpr int kHigh = kTileRows, kBroad = kGroup;  // entries of the product that are summed at a time

/// sum_k A(i, k) B(k, j) for kHigh x kBroad entries; B's rows lie side by side, `broad` apart. As many columns at a
/// time as their sums stay in the registers.
template <int Width>
KT_INLINE void sum_tile_in(const double* a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const double* b,
                           std::ptrdiff_t b_step, std::ptrdiff_t count, double* out) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  for (int column = 0; column < kBroad; column += 2 * Width) {
    Lanes s[kHigh][2] = {};
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      Lanes b0, b1;
      __builtin_memcpy(&b0, b + k * b_step + column, sizeof b0);
      __builtin_memcpy(&b1, b + k * b_step + column + Width, sizeof b1);
      for (int i = 0; i < kHigh; ++i) {
        const double x = a[i * a_row + k * a_step];
        s[i][0] += x * b0;
        s[i][1] += x * b1;
      }
    }
    for (int i = 0; i < kHigh; ++i) __builtin_memcpy(out + kBroad * i + column, s[i], sizeof s[i]);
  }
}
KT_WIDTHS(sum_tile,
          (const double* a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const double* b, std::ptrdiff_t b_step,
           std::ptrdiff_t count, double* out),
          (a, a_row, a_step, b, b_step, count, out))

}  // namespace

void product_tile(const double* a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const double* b, std::ptrdiff_t b_step,
                  std::ptrdiff_t count, double* out) {
  sum_tile(a, a_row, a_step, b, b_step, count, out);
}

void in_groups(const Eigen::Ref<const RowMatrix>& V, std::vector<double>& out) {
  const Eigen::Index groups = (V.cols() + kGroup - 1) / kGroup;
  out.resize(static_cast<std::size_t>(groups * V.rows() * kGroup));
  for (Eigen::Index g = 0; g < groups; ++g)
    for (Eigen::Index k = 0; k < V.rows(); ++k) {
      const Eigen::Index count = std::min<Eigen::Index>(kGroup, V.cols() - kGroup * g);
      double* row = out.data() + kGroup * (V.rows() * g + k);
      std::fill(std::copy_n(V.data() + V.outerStride() * k + kGroup * g, count, row), row + kGroup, 0.0);
    }
}

namespace {

/// Few columns lie side by side as they are: the last group begins earlier instead of ending later. So many rows at a
/// time that they stay in the nearest cache.
MatrixX narrow_symmetric_product(const double* A, const double* B, Eigen::Index n, Eigen::Index k) {
  constexpr Eigen::Index kRows = 64;
  MatrixX out = MatrixX::Zero(k, k);
  double tile[kHigh * kBroad];
  for (Eigen::Index from = 0; from < n; from += kRows)
    for (Eigen::Index i0 = 0; i0 < k; i0 += kHigh)
      for (Eigen::Index c0 = 0; c0 < std::min(i0 + kHigh, k); c0 += kBroad) {
        const Eigen::Index i = std::min(i0, k - kHigh), c = std::min(c0, k - kBroad);
        sum_tile(A + k * from + i, 1, k, B + k * from + c, k, std::min(kRows, n - from), tile);
        for (Eigen::Index r = i0; r < i + kHigh; ++r)
          for (Eigen::Index j = c0; j < std::min(c + kBroad, r + 1); ++j) out(r, j) += tile[kBroad * (r - i) + j - c];
      }
  return out.selfadjointView<Eigen::Lower>();
}

}  // namespace

MatrixX symmetric_product(const Eigen::Ref<const RowMatrix>& A, const Eigen::Ref<const RowMatrix>& B) {
  const Eigen::Index n = A.rows(), k = A.cols();
  if (k >= kBroad && k <= 2 * kBroad && A.outerStride() == k && B.outerStride() == k)
    return narrow_symmetric_product(A.data(), B.data(), n, k);
  return symmetric_product(ColumnGroups(A), ColumnGroups(B));
}

namespace {

/// So many rows at a time that those of two groups stay in the nearest cache. Zeros change no sum: they can be left
/// out.
/// @param is_lower  A's rows are zero right of the diagonal
MatrixX product_of_groups(const ColumnGroups& A, const ColumnGroups& B, bool is_lower) {
  constexpr Eigen::Index kRows = 128;
  const Eigen::Index n = A.rows, k = A.cols;
  MatrixX out = MatrixX::Zero(k, k);
  double tile[kHigh * kBroad];
  for (Eigen::Index from = 0; from < n; from += kRows) {
    const Eigen::Index end = is_lower ? std::min(k, from + kRows) : k;
    for (Eigen::Index c0 = 0; c0 < end; c0 += kBroad)
      for (Eigen::Index i = c0; i < end; i += kHigh) {
        sum_tile(A.group(i / kBroad) + kBroad * from + i % kBroad, 1, kBroad, B.group(c0 / kBroad) + kBroad * from,
                 kBroad, std::min(kRows, n - from), tile);
        // Upper triangle, by columns.
        for (Eigen::Index r = i; r < std::min(i + kHigh, k); ++r)
          for (Eigen::Index c = c0; c < std::min(c0 + kBroad, r + 1); ++c) out(c, r) += tile[kBroad * (r - i) + c - c0];
      }
  }
  return out.selfadjointView<Eigen::Upper>();
}

}  // namespace

MatrixX symmetric_product(const ColumnGroups& A, const ColumnGroups& B) { return product_of_groups(A, B, false); }

MatrixX product_with_itself(const RowMatrix& lower) {
  const ColumnGroups groups(lower);
  return product_of_groups(groups, groups, true);
}

RowMatrix tall_product(const Eigen::Ref<const RowMatrix>& A, const Eigen::Ref<const RowMatrix>& B) {
  thread_local std::vector<double> right;
  in_groups(B, right);
  RowMatrix out(A.rows(), B.cols());
  double tile[kHigh * kBroad];
  for (Eigen::Index i = 0; i < A.rows(); i += kHigh)
    for (Eigen::Index g = 0; kBroad * g < B.cols(); ++g) {
      const Eigen::Index rows = std::min<Eigen::Index>(kHigh, A.rows() - i);
      const Eigen::Index from = rows == kHigh ? i : std::max<Eigen::Index>(0, A.rows() - kHigh);
      if (A.rows() < kHigh) return A.lazyProduct(B);
      sum_tile(A.data() + A.outerStride() * from, A.outerStride(), 1, right.data() + kBroad * B.rows() * g, kBroad,
               A.cols(), tile);
      for (Eigen::Index r = 0; r < kHigh; ++r)
        std::copy_n(tile + kBroad * r, std::min<Eigen::Index>(kBroad, B.cols() - kBroad * g),
                    out.data() + B.cols() * (from + r) + kBroad * g);
    }
  return out;
}

}  // namespace kt
