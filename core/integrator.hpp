#pragma once
// Time integrators of the global model. Backends: integrators.def.
#include <memory>
#include <string>
#include <vector>

#include "core/backend.hpp"
#include "core/deformable_model.hpp"

namespace kt {

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Advances `state` by dt [s] under the model's forces and `external` forces [N], (3n), constant over the step.
  /// Fixed nodes stay. Throws RunError when the step's linear system is not positive definite.
  virtual void step(const DeformableModel& model, const VectorX& external, double dt, State& state) = 0;
  /// Largest stable dt [s] for the highest angular frequency omega_max [rad/s]; infinity when unconditionally stable.
  virtual double stable_step(double omega_max) const = 0;
};

std::vector<BackendInfo> integrator_backends();
std::unique_ptr<Integrator> make_integrator(const std::string& name);

/// Estimate of the highest angular frequency [rad/s] of M, -dfdx over the free nodes: power iteration from a fixed
/// start, from below by a few per cent (take a margin).
double highest_frequency(const DeformableModel& model, const State& state);

}  // namespace kt
