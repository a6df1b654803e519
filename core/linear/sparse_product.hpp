#pragma once
// A sparse matrix times many vectors at once: one pass over the matrix, rows of the vectors side by side.
#include "core/linear/dense/dense_product.hpp"

namespace kt {

/// True where every three columns hold the same whole 3 x 3 blocks.
bool has_node_blocks(const SparseMatrix& A);

/// A symmetric matrix made ready for products: its shape is looked at once, and blocks of zeros are left out of all of
/// them (the mass of a body is mostly such). Borrows the matrix.
class SymmetricMatrix {
 public:
  explicit SymmetricMatrix(const SparseMatrix& A);
  /// A V, (n x k). Fast where A is made of whole 3 x 3 node blocks.
  RowMatrix times(const RowMatrix& V) const;
  /// The same from groups to groups.
  ColumnGroups times(const ColumnGroups& V) const;

 private:
  const SparseMatrix& A_;
  bool in_blocks_;
  std::vector<int> begin_, blocks_;  // of each node column: blocks with numbers, by their first row in its columns
};

/// A x for one vector and a symmetric matrix that is made of whole node blocks: column by column, which is row by row.
VectorX symmetric_blocks_times(const SparseMatrix& A, const VectorX& x);

inline RowMatrix symmetric_times(const SparseMatrix& A, const RowMatrix& V) { return SymmetricMatrix(A).times(V); }

}  // namespace kt
