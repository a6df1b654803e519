#pragma once
// Products of tall matrices with row-major storage: every entry is summed in the order of the rows, on every processor.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// The lower triangle of A^T B, mirrored: for products known to be symmetric. A, B: (n x k).
MatrixX symmetric_product(const Eigen::Ref<const RowMatrix>& A, const Eigen::Ref<const RowMatrix>& B);

/// A B, (n x k) (k x m).
RowMatrix tall_product(const Eigen::Ref<const RowMatrix>& A, const Eigen::Ref<const RowMatrix>& B);

/// Columns in groups of kGroup, the last filled up with zeros: each group's rows one after another, as products read
/// them.
constexpr int kGroup = 16;
void in_groups(const Eigen::Ref<const RowMatrix>& V, std::vector<double>& out);

struct ColumnGroups {
  Eigen::Index rows = 0, cols = 0;
  std::vector<double> numbers;
  ColumnGroups() = default;
  ColumnGroups(Eigen::Index of_rows, Eigen::Index of_cols)
      : rows(of_rows), cols(of_cols), numbers(static_cast<std::size_t>(kGroup * of_rows * num_groups())) {}
  explicit ColumnGroups(const Eigen::Ref<const RowMatrix>& V) : rows(V.rows()), cols(V.cols()) {
    in_groups(V, numbers);
  }
  Eigen::Index num_groups() const { return (cols + kGroup - 1) / kGroup; }
  const double* group(Eigen::Index g) const { return numbers.data() + kGroup * rows * g; }
  double* group(Eigen::Index g) { return numbers.data() + kGroup * rows * g; }
};

/// symmetric_product() of matrices that are in groups already.
MatrixX symmetric_product(const ColumnGroups& A, const ColumnGroups& B);

/// L^T L of a lower triangular matrix, whose zeros are there: symmetric_product()'s bits in a third to all of its time.
MatrixX product_with_itself(const RowMatrix& lower);

/// sum_k A(i, k) B(k, j) for kTileRows x kGroup entries, `out` row by row: what all products are made of.
/// @param a  A(i, k) is at i * a_row + k * a_step      @param b  rows of kGroup numbers, `b_step` apart
constexpr int kTileRows = 4;
void product_tile(const double* a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const double* b, std::ptrdiff_t b_step,
                  std::ptrdiff_t count, double* out);

}  // namespace kt
