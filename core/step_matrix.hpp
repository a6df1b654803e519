#pragma once
// The matrix of an implicit step, m M + d D + k K on the free nodes, summed into a pattern that stays the same.
#include <array>
#include <vector>

#include "core/free_dofs.hpp"
#include "core/sparsity_pattern.hpp"

namespace kt {

struct MatrixTerm {
  double factor = 0;
  const SparseMatrix* matrix = nullptr;  ///< (3n x 3n), symmetric pattern; without entries: left out
};

/// Keeps where every entry goes: a sum costs one pass over the entries, many times less than adding sparse matrices.
class StepMatrix {
 public:
  explicit StepMatrix(FreeDofs dofs) : dofs_(std::move(dofs)) {}

  /// The sum, (3 free x 3 free), in whole 3 x 3 node blocks. Valid until the next call.
  const SparseMatrix& sum(const std::array<MatrixTerm, 3>& terms);
  const FreeDofs& dofs() const { return dofs_; }

 private:
  void make_pattern(const std::array<MatrixTerm, 3>& terms);
  FreeDofs dofs_;
  SparseMatrix sum_;
  std::array<SparsityPattern, 3> patterns_;
  std::array<std::vector<int>, 3> slots_;  // of each term's entries in sum_, -1: fixed
};

}  // namespace kt
