#pragma once
// A symmetric matrix in 3 x 3 node blocks, made ready for many products with one vector: its rows in an order that is
// given, its blocks one after the other, and vectors with four numbers a node, x y z 0, as registers hold them.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

constexpr int kLanes = 4;  ///< numbers of a node in such a vector

class LaneMatrix {
 public:
  /// @param matrix  in whole 3 x 3 node blocks, symmetric
  /// @param order   which of its nodes comes i-th
  void set_pattern(const SparseMatrix& matrix, const std::vector<int>& order);
  /// Takes over the numbers of a matrix of the pattern that was set.
  void update(const SparseMatrix& matrix);

  int num_nodes() const { return static_cast<int>(order_.size()); }
  /// Rows of A x for the nodes first .. last - 1; `dot`: x . A x of them is added, lane by lane.
  void times(const double* x, double* out, int first, int last, double* dot) const;
  /// Block (i, i), in the given order.
  Mat3 diagonal(int i) const;

  /// Between stacked vectors, (3n), and those in lanes.
  void to_lanes(const VectorX& stacked, std::vector<double>& out) const;
  void from_lanes(const std::vector<double>& lanes, VectorX& out) const;

 private:
  std::vector<int> order_, begin_, neighbours_, diagonal_;
  std::vector<double> values_;  // nine a block, column by column, and one more that is only read
};

}  // namespace kt
