// Second order, and as firm on high frequencies as backward Euler: two implicit stages, y1 = y + g dt y1',
// y+ = y + (1-g) dt y1' + g dt y+' with g = 1 - 1/sqrt(2), for y = x and v (Alexander 1977). It needs no step before
// this one, and gives the body exactly the impulse of the forces: contact can come and go between steps.
#include <cmath>

#include "core/global/newton.hpp"

namespace kt {
namespace {

class Sdirk2 final : public NewtonIntegrator {
 public:
  explicit Sdirk2(const IntegratorOptions& options) : NewtonIntegrator(options) {}
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    const double g = 1 - std::sqrt(0.5), t = state.t;
    const State start = state;
    state.t = t + g * dt;
    newton_.solve(model, external, {start.x, start.v, g * dt}, state);
    const VectorX v1 = state.v;  // M (v1 - v) / (g dt) is the force of the first stage
    state.t = t + dt;
    newton_.solve(model, external, {start.x + (1 - g) * dt * v1, start.v + (1 - g) / g * (v1 - start.v), g * dt},
                  state);
  }
};

}  // namespace

std::unique_ptr<Integrator> make_sdirk2_integrator(const IntegratorOptions& options) {
  return std::make_unique<Sdirk2>(options);
}

}  // namespace kt
