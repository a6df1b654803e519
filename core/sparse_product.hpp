#pragma once
// A sparse matrix times many vectors at once: one pass over the matrix, rows of the vectors side by side.
#include "core/types.hpp"

namespace kt {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A V, (n x k). Fast where A is made of whole 3 x 3 node blocks, right for every A.
RowMatrix product(const SparseMatrix& A, const RowMatrix& V);

/// True where every three columns hold the same whole 3 x 3 blocks.
bool has_node_blocks(const SparseMatrix& A);

}  // namespace kt
