#pragma once
// P^T A P for matrices A in 3 x 3 node blocks and an interpolation P: the body's matrices seen by its kept nodes.
#include "core/local/grading.hpp"
#include "core/local/node_blocks.hpp"

namespace kt {

/// Knows where every number goes: made once for an interpolation, then a product costs one pass over the blocks.
class BlockConfinement {
 public:
  BlockConfinement() = default;
  BlockConfinement(const NodeBlocks& blocks, const Interpolation& interpolation);

  /// Lower blocks of the product, column by column, the diagonal first.
  int first(int column) const { return begin_[column]; }
  int last(int column) const { return begin_[column + 1]; }
  int row(int block) const { return rows_[block]; }

  /// @param values  `Size` numbers a block of the NodeBlocks given, whole 3 x 3 blocks one after another
  template <int Size>
  void product(const NodeBlocks& blocks, const std::vector<double>& values, std::vector<double>& out) const;

 private:
  void find_near(const NodeBlocks& blocks);
  void make_rows();
  void find_slots();
  Interpolation p_;
  // Column j of A goes to the kept nodes near_ it (A's column times P^T), from there by row j of P into the sums.
  std::vector<int> near_begin_, near_;
  std::vector<unsigned short> place_;  // among near_ of j: of each entry of row i of P, for each neighbour i of j
  std::vector<int> slots_;             // of the sums: for each entry b of row j of P, those of near_ from b on
  std::vector<int> begin_, rows_;
};

}  // namespace kt
