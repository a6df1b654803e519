#pragma once
// A sparse matrix times many vectors at once: one pass over the matrix, rows of the vectors side by side.
#include "core/dense_product.hpp"

namespace kt {

/// A V, (n x k), for symmetric A. Fast where A is made of whole 3 x 3 node blocks.
RowMatrix symmetric_times(const SparseMatrix& A, const RowMatrix& V);

/// True where every three columns hold the same whole 3 x 3 blocks.
bool has_node_blocks(const SparseMatrix& A);

}  // namespace kt
