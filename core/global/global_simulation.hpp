#pragma once
// The slow side: integrates the full model with the contact force history that the local side returned.
#include <optional>
#include <span>

#include "core/body/node_weights.hpp"
#include "core/global/held_model.hpp"
#include "core/global/integrator.hpp"

namespace kt {

/// What the local side did to the body during one haptic tick at one contact.
struct ContactSample {
  double t = 0;                 ///< start of the tick [s]
  NodeWeights moves{};          ///< global nodes that move the contact point
  Vec3 impulse = Vec3::Zero();  ///< given to the body during the tick [N s]
  Vec3 normal = Vec3::Zero();   ///< unit, from the body towards the tool
  bool sticks = false;          ///< the contact point went with the tool
};

/// Model + integrator + state. advance() catches up to t_end: in equal steps no longer than `max_step`, or in one step
/// with an integrator that is stable at any.
class GlobalSimulation {
 public:
  /// @param max_step  [s], > 0, of an integrator with a stability limit; shortened to 80 % of that limit
  /// @param start     absent: the undeformed body at rest
  GlobalSimulation(const DeformableModel& model, std::unique_ptr<Integrator> integrator, double max_step,
                   std::optional<State> start = {});

  /// Each step feels the impulses of its own time span, as forces spread over it: no impulse is lost or counted twice.
  /// `history` is ascending in t. Throws RunError when the state leaves the finite numbers.
  ///
  /// Contacts that last to the end (`holds`) take over from the normal forces of the history, which are those of a
  /// stiffer local model: their points are held where the tool left them, in one step; see held_model.hpp. Only for an
  /// integrator without a stability limit, else the history acts alone, as in the paper.
  void advance(double t_end, std::span<const ContactSample> history, std::span<const ContactHold> holds = {});

  /// The state `dt` [s] from now, were the contacts at these stops on the way, evenly in time, the last at its end: a
  /// step to each. None when the holds would have to pull, there is none, or the integrator has a stability limit.
  std::optional<State> foresee(double dt, std::span<const std::vector<ContactHold>> stops);

  /// Does what the first step of `dt` [s] does once for all, as the order of its matrix. The state stays.
  void warm_up(double dt);

  const State& state() const { return &all_ == &model_ ? state_ : shown_; }
  const DeformableModel& model() const { return all_; }
  double step() const { return max_step_; }  ///< [s]
  /// After an advance with holds: the normal force that keeps the body where the local model left it, over the one that
  /// the local model gave for it, - 1. What its linearization made of the interval, and the body's own step. -1:
  /// the body would have to be pulled there. 0: no hold.
  double contact_error() const { return contact_error_; }
  StepStatistics statistics() const { return integrator_->statistics(); }

 private:
  void show(const State& own, State& out) const;
  bool advance_held(double t_end, std::span<const ContactSample> history, std::span<const ContactHold> holds);

  const DeformableModel& all_;
  const DeformableModel& model_;  // of the nodes alone
  std::unique_ptr<Integrator> integrator_;
  double max_step_;
  bool unconditional_ = false;  // the integrator is stable at any step, and with stiff springs
  double hold_stiffness_ = 0;   // [N/m], where unconditional
  double friction_scale_ = 1;   // normal force of the body / of the local model, in the last held interval
  double contact_error_ = 0;
  State state_;  // of the nodes alone
  State shown_;  // with an embedded surface; without one empty
};

}  // namespace kt
