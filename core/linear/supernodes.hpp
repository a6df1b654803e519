#pragma once
// Which nodes a sparse Cholesky factorization takes together: the symbolic part, on the graph of 3 x 3 node blocks.
// Davis, Direct Methods for Sparse Linear Systems (2006), chapters 4 and 7; relaxed supernodes as CHOLMOD merges them.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Neighbours of every node, each pair in both lists, without the node itself: of node j begin[j] .. begin[j + 1].
struct NodeNeighbours {
  std::vector<int> begin, neighbour;
  int size() const { return static_cast<int>(begin.size()) - 1; }
};

/// From the lower triangle of a matrix in whole node blocks.
NodeNeighbours node_neighbours(const SparseMatrix& matrix);

/// Successive nodes of the order, which share their rows of the factor.
struct Supernode {
  int first = 0, count = 0;  ///< nodes: places in the order
  std::vector<int> below;    ///< places of the rows below them, ascending
  /// Some rows below belong to one later supernode: its own columns from there on change by these ones' product.
  struct Run {
    int target = 0;         ///< supernode
    int from = 0, to = 0;   ///< entries of `below`
    std::vector<int> rows;  ///< in the target, of below[from ..]: 0 is its first node
  };
  std::vector<Run> runs;
};

struct Supernodes {
  std::vector<int> order;  ///< node that comes first, second, ..
  std::vector<Supernode> nodes;
  double flops = 0;    ///< of a factorization
  double entries = 0;  ///< numbers of the factor
};

/// @param last  nodes that are to come last, where loads are: a solution then starts there
Supernodes find_supernodes(const NodeNeighbours& graph, const std::vector<int>& last = {});

}  // namespace kt
