// Equilibrium at every step: f(x, 0) + external = 0. No inertia, no damping: what remains when all motion is slow.
#include <limits>

#include "core/newton.hpp"

namespace kt {
namespace {

class Quasistatic final : public Integrator {
 public:
  explicit Quasistatic(const IntegratorOptions& options) : newton_(options) {}
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    const double t = state.t;
    state.v.setZero();
    newton_.solve(model, external, {state.x, state.v, 1, true}, state);
    state.v.setZero();
    state.t = t + dt;
  }
  double stable_step(const FastestMode&) const override { return std::numeric_limits<double>::infinity(); }
  bool is_dynamic() const override { return false; }
  StepStatistics statistics() const override { return newton_.statistics(); }

 private:
  NewtonSolver newton_;
};

}  // namespace

std::unique_ptr<Integrator> make_quasistatic_integrator(const IntegratorOptions& options) {
  return std::make_unique<Quasistatic>(options);
}

}  // namespace kt
