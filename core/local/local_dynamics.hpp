#pragma once
// A LocalModel made ready for the haptic tick: everything that needs a factorization is done here, at the refresh.
#include <Eigen/SparseCholesky>
#include <memory>

#include "core/linear/dense/panel_product.hpp"
#include "core/local/local_model.hpp"

namespace kt {

/// How the free motion of the local model is stepped.
enum class LocalScheme {
  symplectic_euler,  ///< A = M: explicit, the paper's equation 11
  implicit_euler,    ///< A = M + h D + h^2 K: unconditionally stable
  exact              ///< every vibration by its own exponential, forces constant over the step; needs is_uncoupled()
};

/// The inner product in which a contact constraint is projected (docs/method.md#6-the-papers-laws-528). implicit: the
/// scheme's own, in which the end of the step meets the constraint.
enum class Metric { identity, mass, implicit };

/// Change of the body's mean velocity over the step per contact impulse: dq / h = Y J^T p; the same at the patch: C = B
/// Y.
struct Response {
  MatrixX Y;  ///< (r x 3p)
  MatrixX C;  ///< (3p x 3p)
};

/// Mass, damping and stiffness are diagonal: the coordinates are vibrations that do not know of one another.
bool is_uncoupled(const LocalModel& model);

class LocalDynamics {
 public:
  /// @param h  haptic step [s], > 0.  Throws RunError when A is not positive definite, InputError when the scheme is
  /// exact and the model is not uncoupled.
  LocalDynamics(const LocalModel& model, LocalScheme scheme, Metric metric, double h);

  /// A step without contact: the mean velocity over it, q+ = q + h mean, and the velocity at its end. Both are the same
  /// in Euler's schemes: A v+ = M v + h (f0 - K q) [+ explicit damping]. No allocation.
  void free_motion(const VectorX& q, const VectorX& q_rate, VectorX& mean, VectorX& end) const noexcept;

  /// Force of the linear model at (q, q') [N], (r). No allocation.
  void force(const VectorX& q, const VectorX& q_rate, VectorX& out) const noexcept;

  const Response& inertia() const { return inertia_; }                                ///< through A: how forces act
  const Response& metric() const { return metric_is_inertia_ ? inertia_ : metric_; }  ///< how constraints act
  /// Change of the velocity at the end of the step per contact impulse that acts as a constraint, (r x 3p).
  const MatrixX& end_response() const { return end_response_.size() ? end_response_ : metric().Y; }
  /// Change of the velocity by an impulse at one moment, through M^-1; empty where the end of a step has the velocity
  /// that a constraint asks for anyway.
  const Response& kick() const { return kick_; }
  double h() const { return h_; }

 private:
  /// Each coordinate by itself: mean and end velocity are linear in its q, q' and force; (r) each.
  struct Vibrations {
    VectorX mean_q, mean_rate, mean_force, end_q, end_rate, end_force;
  };
  void make_vibrations();
  void make_exact(double mass, double damping, double stiffness, int i);
  void solve(VectorX& in_out) const noexcept;
  const LocalModel& model_;
  LocalScheme scheme_;
  double h_;
  Vibrations vibrations_;      ///< when the model is uncoupled
  VectorX diagonal_inverse_;   ///< else, when A is diagonal
  PanelMatrix dense_inverse_;  ///< else, when it is small
  SparseMatrix lower_;         ///< else A = P^T L L^T P
  Eigen::VectorXi permutation_;
  Response inertia_, metric_;
  MatrixX end_response_;  ///< when it is not metric().Y
  Response kick_;
  bool metric_is_inertia_ = false;
  mutable VectorX rhs_, permuted_;
};

}  // namespace kt
