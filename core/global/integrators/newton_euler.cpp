// Backward Euler solved to the end: M (v+ - v) = dt (f(x+, v+) + external),  x+ = x + dt v+.
#include "core/global/newton.hpp"

namespace kt {
namespace {

class NewtonEuler final : public NewtonIntegrator {
 public:
  explicit NewtonEuler(const IntegratorOptions& options) : NewtonIntegrator(options) {}
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    const double t = state.t;
    newton_.solve(model, external, {state.x, state.v, dt}, state);
    state.t = t + dt;
  }
};

}  // namespace

std::unique_ptr<Integrator> make_newton_euler_integrator(const IntegratorOptions& options) {
  return std::make_unique<NewtonEuler>(options);
}

}  // namespace kt
