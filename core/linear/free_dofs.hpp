#pragma once
// Leaving the fixed nodes out of vectors and matrices, and putting them back.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Map between all 3n entries and those of the free nodes.
struct FreeDofs {
  std::vector<int> to_free;  ///< (3n), -1 for a fixed entry
  std::vector<int> to_all;   ///< (3 free)
  int size() const { return static_cast<int>(to_all.size()); }
};

FreeDofs make_free_dofs(int num_nodes, const std::vector<int>& fixed_nodes);

VectorX gather(const FreeDofs& dofs, const VectorX& all);
SparseMatrix gather(const FreeDofs& dofs, const SparseMatrix& all);

/// Writes the free entries into `out` (3n) and leaves the others.
void scatter(const FreeDofs& dofs, const VectorX& free, VectorX& out);

}  // namespace kt
