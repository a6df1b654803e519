#pragma once
// The slow side: integrates the full model with the contact force history that the local side returned.
#include <span>

#include "core/integrator.hpp"

namespace kt {

/// What the local side did to the body during one haptic tick at one contact.
struct ContactSample {
  double t = 0;                  ///< start of the tick [s]
  std::array<int, 3> nodes{};    ///< global nodes of the touched triangle
  Vec3 bary = Vec3::Zero();      ///< their weights
  Vec3 impulse = Vec3::Zero();   ///< given to the body during the tick [N s]
};

/// Model + integrator + state. advance() catches up to t_end in equal steps no longer than `max_step`.
class GlobalSimulation {
 public:
  /// @param max_step  [s], > 0; shortened to 80 % of the integrator's stability limit where it has one
  GlobalSimulation(const DeformableModel& model, std::unique_ptr<Integrator> integrator, double max_step);

  /// Each step feels the impulses of its own time span, as forces spread over it: no impulse is lost or counted twice.
  /// `history` is ascending in t. Throws RunError when the state leaves the finite numbers.
  void advance(double t_end, std::span<const ContactSample> history);

  const State& state() const { return state_; }
  const DeformableModel& model() const { return model_; }
  double step() const { return max_step_; }  ///< [s]

 private:
  const DeformableModel& model_;
  std::unique_ptr<Integrator> integrator_;
  double max_step_;
  State state_;
};

}  // namespace kt
