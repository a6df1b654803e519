#include "self_contact/touching_euler.hpp"

namespace kt {

namespace {

/// Barriers are stiff, and conjugate gradients slow for them.
IntegratorOptions with_direct_solver(IntegratorOptions options) {
  if (options.solver == "automatic") options.solver = "direct";
  return options;
}

}  // namespace

TouchingEuler::TouchingEuler(SelfContact& contact, const IntegratorOptions& options)
    : contact_(contact), newton_(make_integrator("newton_euler", with_direct_solver(options))) {}

TouchingEuler::~TouchingEuler() = default;

void TouchingEuler::step(const DeformableModel& model, const VectorX& external, double dt, State& state) {
  const TouchingModel touching(model, contact_, state, dt);
  newton_->step(touching, external, dt, state);
  report_ = touching.report(state.x);
}

double TouchingEuler::stable_step(const FastestMode& mode) const { return newton_->stable_step(mode); }

StepStatistics TouchingEuler::statistics() const { return newton_->statistics(); }

}  // namespace kt
