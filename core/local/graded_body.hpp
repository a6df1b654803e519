#pragma once
// The whole linearized body seen from a contact, in a few hundred nodes: what makes a reduction of a large body fit
// into a refresh. Near the patch every node keeps its motion; the others follow fewer and fewer nodes (grading.hpp). A
// few motions of the whole body are added: how it yields at rest to the loads that are felt furthest away, the
// resultant force on the patch and its first moments, and the slowest vibrations, which the spacing of far nodes would
// make too fast. All of it is a confinement of the same body
// (Galerkin): stiffness and damping stay positive, and what is left out only makes it a little stiffer.
#include "core/linear/copied_solver.hpp"
#include "core/local/block_confinement.hpp"
#include "core/local/far_motions.hpp"
#include "core/local/subspace.hpp"

namespace kt {

/// Keeps what one refresh can leave to the next, of one body: which nodes are kept while the patch stays near, where
/// every number goes, and the far motions, which are improved a little at each refresh instead of solved for.
class GradedBody {
 public:
  explicit GradedBody(GradingOptions options = {}) : options_(options) {}

  /// The body's matrices and force in the coordinates of the kept nodes and the far motions. `dofs` maps the kept nodes
  /// only, all free ones of the patch among them. Valid until the next call.
  const FreeBody& update(const TangentModel& tangent, const SurfacePatch& patch);

  /// All free nodes, nothing left out.
  const FreeBody& update_whole(const TangentModel& tangent);

  /// For the matrices of this body, so that their symbolic analysis is done once while the pattern stays.
  SparseSolver& solver() { return *solver_; }
  int num_kept() const { return static_cast<int>(interpolation_.kept.size()); }
  int gradings() const { return gradings_; }               ///< how often the kept nodes were chosen anew
  bool is_graded_anew() const { return is_graded_anew_; }  ///< by the last update: it cost more than others do

  static constexpr int kLoads = 12, kSlow = 12, kFar = kLoads + kSlow;  ///< far motions

  /// Displacement of all free nodes from the coordinates, (3 free x M) from (coordinates x M).
  template <int M>
  NodeRows<M> expand(const NodeRows<M>& coordinates) const;
  /// The transpose: generalized forces from nodal ones.
  template <int M>
  NodeRows<M> contract(const NodeRows<M>& forces) const;
  /// Of the last local model made from this body: its coordinates q move the body's by V combination q.
  struct Motions {
    RowMatrix V;
    MatrixX combination;
    bool of_dof(int dof) const { return combination.cols() == dof; }
  };
  const Motions& motions() const { return motions_; }
  /// The solver has to hold a factor of this body's K + s D + s^2 M, for some s.
  void set_motions(Motions motions) {
    motions_ = std::move(motions);
    is_factored_ = leads_far_ = true;
  }

  /// A cheap approximate inverse of K + w D + w^2 M on all free nodes: the kept nodes' and far motions' exact one, or
  /// the one at hand where motions were set, and each follower's own.
  class Preconditioner {
   public:
    /// Throws IndefiniteTangent when the matrix is not positive definite on the kept nodes.
    Preconditioner(const GradedBody& body, double w);
    NodeRows<6> apply(const NodeRows<6>& forces) const;

   private:
    const GradedBody& body_;
    std::vector<Mat3> node_inverse_;
  };

  const NodeBlocks& blocks() const { return blocks_; }
  const FreeDofs& all_dofs() const { return dofs_; }
  bool is_whole() const { return whole_; }

 private:
  using FarBlock = Eigen::Matrix<double, kFar, kFar>;
  bool covers(const TangentModel& tangent, const SurfacePatch& patch) const;
  void choose_nodes(const TangentModel& tangent, const SurfacePatch& patch);
  void make_matrix_pattern();
  void factor_preconditioner();
  std::vector<Mat3> follower_inverses(double w) const;
  FarRows precondition(const FarRows& residual) const;
  void improve_far_motions(const TangentModel& tangent, const SurfacePatch& patch, int turns, int steps);
  void set_far_apart();
  void fill_matrices();
  void fill(SparseMatrix& out, const double* blocks, int size, const NodeRows<kFar>& times_far) const;
  template <int M>
  NodeRows<M> prolong(const NodeRows<M>& kept) const;
  template <int M>
  NodeRows<M> restrict_forces(const NodeRows<M>& forces) const;

  GradingOptions options_;
  FreeDofs dofs_;  // of the whole body
  NodeBlocks blocks_;
  std::vector<double> ranks_;  // of its nodes
  std::vector<char> fixed_;    // nodes
  bool whole_ = false;         // too small a body to leave nodes out
  int gradings_ = 0;
  VectorX graded_x_;               // node positions and
  std::vector<int> graded_patch_;  // patch that the nodes were chosen for
  double edge_ = 0;                // of it [m]
  Interpolation interpolation_;
  std::vector<int> kept_row_;   // free node of each kept one
  std::vector<int> followers_;  // free nodes that are not kept

  BlockConfinement confinement_;
  std::vector<double> sums_, mass_sums_;    // of stiffness and damping; of the mass
  std::vector<std::array<int, 2>> begins_;  // of each of its blocks and of its transpose: first number in the matrices
  SparseMatrix pattern_;                    // kept nodes, then far motions as if they were nodes, in whole blocks

  FarRows yielding_, vibrations_;          // improved from refresh to refresh
  int turns_ = 0;                          // of improving them
  NodeRows<kFar> far_apart_;               // both less what the kept nodes do: zero at those
  FarBlock far_basis_ = FarBlock::Zero();  // of far_apart_, columns orthonormal in the mass; zero columns: dropped
  std::vector<Mat3> node_inverse_;         // of the diagonal blocks of nodes that follow
  SolverValue coarse_ = make_sparse_solver(), solver_ = make_sparse_solver();
  bool has_coarse_ = false;
  double added_mass_ = 0;     // [1/s^2], of a body that is free to move
  bool is_factored_ = false;  // solver_, since the last update
  bool leads_far_ = false;    // solver_ holds a factor of these kept nodes' body, of the refresh before
  bool rests_ = false;        // far motions are improved at every other update
  bool is_graded_anew_ = false;
  FreeBody body_;
  Motions motions_;
};

template <int M>
NodeRows<M> GradedBody::prolong(const NodeRows<M>& kept) const {
  const int nodes = static_cast<int>(interpolation_.begin.size()) - 1;
  NodeRows<M> out = NodeRows<M>::Zero(3 * nodes, M);
  for (int i = 0; i < nodes; ++i)
    for (int e = interpolation_.begin[i]; e < interpolation_.begin[i + 1]; ++e)
      out.template middleRows<3>(3 * i) +=
          interpolation_.weight[e] * kept.template middleRows<3>(3 * interpolation_.column[e]);
  return out;
}

template <int M>
NodeRows<M> GradedBody::restrict_forces(const NodeRows<M>& forces) const {
  NodeRows<M> out = NodeRows<M>::Zero(3 * num_kept(), M);
  for (int i = 0; i + 1 < static_cast<int>(interpolation_.begin.size()); ++i)
    for (int e = interpolation_.begin[i]; e < interpolation_.begin[i + 1]; ++e)
      out.template middleRows<3>(3 * interpolation_.column[e]) +=
          interpolation_.weight[e] * forces.template middleRows<3>(3 * i);
  return out;
}

template <int M>
NodeRows<M> GradedBody::expand(const NodeRows<M>& coordinates) const {
  if (whole_) return coordinates;
  NodeRows<M> out = prolong<M>(coordinates.topRows(3 * num_kept()));
  out += far_apart_ * (far_basis_ * coordinates.template bottomRows<kFar>());
  return out;
}

template <int M>
NodeRows<M> GradedBody::contract(const NodeRows<M>& forces) const {
  if (whole_) return forces;
  NodeRows<M> out(3 * num_kept() + kFar, M);
  out << restrict_forces<M>(forces), far_basis_.transpose() * (far_apart_.transpose() * forces);
  return out;
}

}  // namespace kt
