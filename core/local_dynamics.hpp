#pragma once
// A LocalModel made ready for the haptic tick: everything that needs a factorization is done here, at the refresh.
#include <Eigen/SparseCholesky>
#include <memory>

#include "core/local_model.hpp"

namespace kt {

/// How the free motion of the local model is stepped.
enum class LocalScheme {
  symplectic_euler,  ///< A = M: explicit, the paper's equation 11
  implicit_euler     ///< A = M + h D + h^2 K: unconditionally stable
};

/// The inner product in which a contact constraint is projected; method.md section 5, note 4.
enum class Metric { identity, mass, implicit };

/// Velocity change of the body per contact impulse: dq' = Y J^T p, and the same seen at the patch: C = B Y.
struct Response {
  MatrixX Y;  ///< (r x 3p)
  MatrixX C;  ///< (3p x 3p)
};

class LocalDynamics {
 public:
  /// @param h  haptic step [s], > 0.  Throws RunError when A is not positive definite.
  LocalDynamics(const LocalModel& model, LocalScheme scheme, Metric metric, double h);

  /// Velocity at the end of a step without contact: A v+ = M v + h (f0 - K q) [+ explicit damping]. No allocation.
  void free_velocity(const VectorX& q, const VectorX& q_rate, VectorX& out) const noexcept;

  /// Force of the linear model at (q, q') [N], (r). No allocation.
  void force(const VectorX& q, const VectorX& q_rate, VectorX& out) const noexcept;

  const Response& inertia() const { return inertia_; }                                ///< through A: how forces act
  const Response& metric() const { return metric_is_inertia_ ? inertia_ : metric_; }  ///< how constraints act
  double h() const { return h_; }

 private:
  void solve(VectorX& in_out) const noexcept;
  const LocalModel& model_;
  LocalScheme scheme_;
  double h_;
  VectorX diagonal_inverse_;  ///< when A is diagonal
  MatrixX dense_inverse_;     ///< when it is small
  SparseMatrix lower_;        ///< else A = P^T L L^T P
  Eigen::VectorXi permutation_;
  Response inertia_, metric_;
  bool metric_is_inertia_ = false;
  mutable VectorX rhs_, permuted_;
};

}  // namespace kt
