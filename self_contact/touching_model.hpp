#pragma once
// A body, or several in one mesh, whose surface does not pass through itself: the model with a barrier and friction
// between all near pairs of vertices, triangles and edges.                         Li et al. 2020, with differences:
// the barrier is one of the distance, not of its square; its Hessian keeps only the positive part along the normal.
//
// A barrier and no complementarity solver, because the step that follows must be free of intersections whatever
// happens: here every iterate is, converged or not, and the solver of the step stays the one of bodies without contact.
#include "collision/broad/surface_pairs.hpp"
#include "core/body/wrapping_model.hpp"
#include "self_contact/barrier.hpp"

namespace kt {

struct SelfContactOptions {
  double reach = 0;      ///< distance from which on surfaces repel [m]; 0: a fiftieth of the mean edge
  double stiffness = 0;  ///< of the barrier [N/m]; 0: that of the body at its surface nodes
  double mu = 0.3;       ///< coefficient of friction [-], >= 0
  double creep = 1e-3;   ///< speed below which friction is smoothed, [m/s] > 0: what seems to stick slides so slowly
  std::string backend = "brute_force";  ///< collision/broad/triangle_index.def
};

/// What the contacts of the last state add up to.
struct SelfContactReport {
  int contacts = 0;    ///< pairs within reach
  double nearest = 0;  ///< distance of the nearest pair [m]; infinity without any
  double normal = 0;   ///< sum of the normal forces [N]
  double energy = 0;   ///< of the barrier [J]
};

/// The surfaces of one body: what does not change from step to step.
struct SelfContact {
  SelfContact(const DeformableModel& model, SelfContactOptions options);
  SelfContactOptions options;  ///< complete
  Barrier barrier;
  SurfacePairs pairs;
  VectorX rest;  ///< positions [m], (3n)
};

/// Borrows the model and the contact; for one step, from one thread: friction is that of the contacts at its start.
///
/// For a local model, linearize it at the end of the step, after find_near(): with the tangents that are not exact,
/// what sticks is a spring that ends where the step began, and what slides a damper. Both have the step's friction and
/// can only take energy that they were given, where the exact derivative of sliding would push on when it turns back.
class TouchingModel final : public WrappingModel {
 public:
  /// @param start  free of intersections      @param dt  of the step [s], > 0
  TouchingModel(const DeformableModel& model, SelfContact& contact, const State& start, double dt);
  void force(const State& state, VectorX& out) const override;
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override;
  double free_share(const VectorX& x, const VectorX& dx) const override;

  /// From here on forces and tangents are asked for at x, (3n), only.
  void find_near(const VectorX& x) const;
  /// Of the contacts at x. Asks find_near().
  SelfContactReport report(const VectorX& x) const;

 private:
  /// A pair within reach.
  struct Touch {
    std::array<int, 4> nodes{};
    std::array<double, 4> weight{};
    Vec3 normal = Vec3::Zero();
    double slope = 0, bend = 0;  ///< of the barrier, with the share that nearly parallel edges count with
    std::array<Vec3, 4> turn{};  ///< gradient by way of that share [N]
    double distance = 0, energy = 0;
  };
  struct Rub {
    std::array<int, 4> nodes{};
    std::array<double, 4> weight{};
    Vec3 normal = Vec3::Zero();
    double normal_force = 0;
  };
  std::vector<Touch> touches(const VectorX& x) const;
  Vec3 slip(const Rub& rub, const VectorX& x) const;

  SelfContact& contact_;
  VectorX x_start_;
  double dt_;
  double slip_scale_ = 0;  // slip from which on friction is full [m]
  std::vector<Rub> rubs_;
  // The pairs that may touch during the motion that free_share() or find_near() was asked for last.
  mutable std::vector<SurfacePair> candidates_;
  mutable Tangent own_;
};

}  // namespace kt
