// Equilibrium at every step: f(x, 0) + external = 0. No inertia, no damping: what remains when all motion is slow.
#include "core/global/newton.hpp"

namespace kt {
namespace {

class Quasistatic final : public NewtonIntegrator {
 public:
  explicit Quasistatic(const IntegratorOptions& options) : NewtonIntegrator(options) {}
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    const double t = state.t;
    state.v.setZero();
    newton_.solve(model, external, {state.x, state.v, 1, true}, state);
    state.v.setZero();
    state.t = t + dt;
  }
  bool is_dynamic() const override { return false; }
};

}  // namespace

std::unique_ptr<Integrator> make_quasistatic_integrator(const IntegratorOptions& options) {
  return std::make_unique<Quasistatic>(options);
}

}  // namespace kt
