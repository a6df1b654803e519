#pragma once
// Products of tall matrices with row-major storage: every entry is summed in the order of the rows, on every processor.
#include <vector>

#include "core/types.hpp"

namespace kt {

/// The lower triangle of A^T B, mirrored: for products known to be symmetric. A, B: (n x k).
MatrixX symmetric_product(const Eigen::Ref<const RowMatrix>& A, const Eigen::Ref<const RowMatrix>& B);

/// A B, (n x k) (k x m).
RowMatrix tall_product(const RowMatrix& A, const RowMatrix& B);

/// Columns in groups of kGroup, the last filled up with zeros: each group's rows one after another.
constexpr int kGroup = 16;
void in_groups(const Eigen::Ref<const RowMatrix>& V, std::vector<double>& out);

/// sum_k A(i, k) B(k, j) for kTileRows x kGroup entries, `out` row by row: what all products are made of.
/// @param a  A(i, k) is at i * a_row + k * a_step      @param b  rows of kGroup numbers, `b_step` apart
constexpr int kTileRows = 4;
void product_tile(const double* a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const double* b, std::ptrdiff_t b_step,
                  std::ptrdiff_t count, double* out);

}  // namespace kt
