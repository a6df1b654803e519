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

}  // namespace kt
