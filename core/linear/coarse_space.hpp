#pragma once
// The coarse problem of a preconditioner: groups of neighbouring nodes that move as rigid bodies, for what spreads far
// (Nicolaides 1987; rigid groups as in smoothed aggregation, Vanek, Mandel and Brezina 1996).
#include <memory>
#include <vector>

#include "core/linear/sparse_solver.hpp"

namespace kt {

/// Column of node blocks j of a matrix in whole node blocks: rows of nodes and values.
struct BlockColumn {
  BlockColumn(const SparseMatrix& m, int j) {
    const int* outer = m.outerIndexPtr() + 3 * j;
    rows = m.innerIndexPtr() + outer[0];
    count = (outer[1] - outer[0]) / 3;
    for (int c = 0; c < 3; ++c) column[c] = m.valuePtr() + outer[c];
  }
  int node(int k) const { return rows[3 * k] / 3; }
  Mat3 block(int k) const {
    Mat3 out;
    for (int c = 0; c < 3; ++c) out.col(c) = Vec3::Map(column[c] + 3 * k);
    return out;
  }
  const int* rows;
  const double* column[3];
  int count;
};

class CoarseSpace {
 public:
  /// @param matrix     whose pattern tells which nodes are neighbours
  /// @param positions  of the nodes, (3n) [m]
  CoarseSpace(const SparseMatrix& matrix, const VectorX& positions);

  /// Factors P^T matrix P, P the groups' motions. False when it is not positive definite.
  bool update(const SparseMatrix& matrix);
  /// (P^T A P)^-1 loads, six numbers a group: forces and moments, translations and turns.
  void solve(const VectorX& loads, VectorX& motions) const;

  int num_groups() const { return static_cast<int>(members_begin_.size()) - 1; }
  /// The nodes, group by group, and where each group begins among them.
  const std::vector<int>& members() const { return members_; }
  const std::vector<int>& members_begin() const { return members_begin_; }
  /// From its group's centre to a node, in units of the groups' size, so that the coarse matrix is well scaled.
  Vec3 arm(int node) const { return arm_.col(node); }

 private:
  void group_nodes(const SparseMatrix& matrix);
  void make_pattern(const SparseMatrix& matrix);
  std::vector<int> group_;                    // of each node
  std::vector<int> members_, members_begin_;  // nodes of each group
  Eigen::Matrix3Xd arm_;
  SparseMatrix coarse_;
  std::vector<int> slots_;  // of each node block: first row in its group's column
  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
  MatrixX inverse_;  // of the coarse matrix, when it is small
};

}  // namespace kt
