#pragma once
// The matrix of an implicit step, m M + d D + k K on the free nodes, summed into a pattern that stays the same.
#include <array>
#include <vector>

#include "core/linear/free_dofs.hpp"
#include "core/linear/sparsity_pattern.hpp"

namespace kt {

struct MatrixTerm {
  double factor = 0;
  const SparseMatrix* matrix = nullptr;  ///< (3n x 3n), symmetric pattern; without entries: left out
};

/// Keeps where the entries go, in runs that stay together: a sum costs one pass over them, many times less than adding
/// sparse matrices.
class StepMatrix {
 public:
  explicit StepMatrix(FreeDofs dofs) : dofs_(std::move(dofs)) {}

  /// The sum, (3 free x 3 free), in whole 3 x 3 node blocks. Valid until the next call.
  const SparseMatrix& sum(const std::array<MatrixTerm, 3>& terms);
  /// Adds factor times `entries`, (3n x 3n), to the last sum, but for those of fixed nodes. False, and nothing has
  /// changed, where the pattern lacks one.
  bool add(double factor, const std::vector<Eigen::Triplet<double>>& entries);
  /// factor times `entries`, (3n x 3n), of the free nodes alone.
  std::vector<Eigen::Triplet<double>> of_free_nodes(double factor,
                                                    const std::vector<Eigen::Triplet<double>>& entries) const;
  const FreeDofs& dofs() const { return dofs_; }
  /// The rows of the free nodes of  matrix x,  (3 free), for one of the terms of the last sum, which must be symmetric:
  /// quickly where it is made of whole node blocks.
  VectorX symmetric_times(std::size_t term, const SparseMatrix& matrix, const VectorX& x) const;

 private:
  void make_pattern(const std::array<MatrixTerm, 3>& terms);
  FreeDofs dofs_;
  SparseMatrix sum_;
  std::array<SparsityPattern, 3> patterns_;
  struct Run {
    int from, to, length;  // entries of a term, of sum_
  };
  std::array<std::vector<Run>, 3> runs_;
  std::array<bool, 3> in_blocks_{};
};

}  // namespace kt
