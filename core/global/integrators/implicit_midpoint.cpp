// v+ = v + dt M^-1 (f + external) and x+ = x + dt v', all at the middle (x + x+)/2, v' = (v + v+)/2. Second order;
// keeps linear and angular momentum, and of linear bodies the energy: nothing is damped that the model does not damp,
// so motions faster than the step ring on.
#include "core/global/newton.hpp"

namespace kt {
namespace {

class ImplicitMidpoint final : public NewtonIntegrator {
 public:
  explicit ImplicitMidpoint(const IntegratorOptions& options) : NewtonIntegrator(options) {}
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    const State start = state;
    state.t = start.t + dt / 2;
    newton_.solve(model, external, {start.x, start.v, dt / 2}, state);
    state.x += dt / 2 * state.v;
    state.v = 2 * state.v - start.v;
    for (int i : model.fixed_nodes()) {
      node(state.x, i) = node(start.x, i);
      node(state.v, i) = node(start.v, i);
    }
    state.t = start.t + dt;
  }
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_midpoint_integrator(const IntegratorOptions& options) {
  return std::make_unique<ImplicitMidpoint>(options);
}

}  // namespace kt
