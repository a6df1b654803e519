#pragma once
// Stiffness, damping and mass of the free nodes as symmetric 3 x 3 blocks, one for every two neighbours: half the
// memory of sparse matrices, and products with several vectors at once go through it at the speed of memory.
#include "core/body/tangent_model.hpp"
#include "core/linear/free_dofs.hpp"
#include "core/linear/sparsity_pattern.hpp"

namespace kt {

template <int M>
using NodeRows =
    Eigen::Matrix<double, Eigen::Dynamic, M, M == 1 ? Eigen::ColMajor : Eigen::RowMajor>;  ///< (3 free x M)

class NodeBlocks {
 public:
  static constexpr int kSize = 18;  ///< numbers of a pair of blocks: stiffness, then damping, column by column

  /// The symmetric parts of -dfdx and -dfdv on the free nodes. Their pattern, and the mass, are taken over at the first
  /// call and when the pattern changes: then true.
  bool update(const TangentModel& tangent, const FreeDofs& dofs);

  int num_nodes() const { return static_cast<int>(begin_.size()) - 1; }
  /// Neighbours of free node j, itself among them, ascending: neighbour(k) for k = first(j) .. last(j) - 1.
  int first(int j) const { return around_begin_[j]; }
  int last(int j) const { return around_begin_[j + 1]; }
  int neighbour(int k) const { return around_[k]; }
  /// Which pair of blocks joins neighbour(k) and j, the row of the one with the higher number.
  int block(int k) const { return around_block_[k]; }
  int diagonal(int j) const { return begin_[j]; }
  const std::vector<double>& values() const { return values_; }
  const std::vector<double>& mass_values() const { return mass_; }  ///< nine a block

  /// K u for 12 motions u; K u and D u, going through both once, for 6 or 24; M u for any of these.
  template <int M>
  void stiffness(const NodeRows<M>& u, NodeRows<M>& out) const;
  template <int M>
  void stiffness_and_damping(const NodeRows<M>& u, NodeRows<M>& forces, NodeRows<M>& damped) const;
  template <int M>
  void mass(const NodeRows<M>& u, NodeRows<M>& out) const;

 private:
  void make_pattern(const TangentModel& tangent, const FreeDofs& dofs);
  std::vector<int> begin_, rows_;  // lower blocks of each column, the diagonal first
  std::vector<double> values_, mass_;
  bool lumped_ = false;  // mass only on the diagonal of the matrix
  std::vector<int> around_begin_, around_, around_block_;
  struct Place {  // of an entry of dfdx or dfdv, and where in values_ it is added
    int from, to;
  };
  struct Places {
    std::vector<Place> columns, rows;  // three entries along a column or a row of a block
    std::vector<Place> others;         // of matrices that are not in whole blocks
  };
  std::array<Places, 2> places_;             // of dfdx and dfdv
  std::array<SparsityPattern, 2> patterns_;  // of dfdx and dfdv
};

}  // namespace kt
