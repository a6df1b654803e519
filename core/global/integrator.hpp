#pragma once
// Time integrators of the global model. Backends: integrators.def.
#include <memory>
#include <string>
#include <vector>

#include "core/base/backend.hpp"
#include "core/body/deformable_model.hpp"

namespace kt {

/// The motion that limits explicit steps, as the scalar x'' = -omega^2 x - 2 zeta omega x'.
struct FastestMode {
  double omega = 0;  ///< [rad/s]
  double zeta = 0;   ///< damping ratio
};

struct IntegratorOptions {
  std::string solver = "automatic";  ///< of implicit steps: step_solvers.def
  double tolerance = 1e-6;           ///< of an iterative solver: |residual| / |rhs|
  double convergence = 1e-9;         ///< of Newton's method: the last displacement, of the body's size
  bool definite = true;              ///< implicit_euler: steps with the definite tangent; else only where it must
};

/// What the implicit steps so far took.
struct StepStatistics {
  int iterations = 0;         ///< linear systems of Newton's method
  int projected = 0;          ///< where the exact tangent was not positive definite and the definite one served
  int not_converged = 0;      ///< steps
  int linear_iterations = 0;  ///< of an iterative solver
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Advances `state` by dt [s] under the model's forces and `external` forces [N], (3n), constant over the step.
  /// Fixed nodes stay. Throws RunError when the step's linear system is not positive definite.
  virtual void step(const DeformableModel& model, const VectorX& external, double dt, State& state) = 0;
  /// Largest stable dt [s] of the scalar motion; infinity when unconditionally stable.
  virtual double stable_step(const FastestMode& mode) const = 0;
  /// False: inertia and damping play no part.
  virtual bool is_dynamic() const { return true; }
  virtual StepStatistics statistics() const { return {}; }
  /// A step that is only looked ahead with: an iterative solver stops at a thousandth, from the last such step's
  /// solution.
  virtual void look_ahead(const DeformableModel& model, const VectorX& external, double dt, State& state) {
    step(model, external, dt, state);
  }
};

std::vector<BackendInfo> integrator_backends();
std::unique_ptr<Integrator> make_integrator(const std::string& name, const IntegratorOptions& options = {});

/// The mode u of the free nodes that binds symplectic Euler, from the Rayleigh quotients k, d, m of u with the definite
/// -dfdx, -dfdv and the mass: omega^2 = k / m, 2 zeta omega = d / m. Damping need not be proportional: the step h is
/// stable exactly when 4 M - 2 h D - h^2 K > 0, so u is the one whose h^2 k + 2 h d reaches 4 m first, not always the
/// one with the highest omega. Found by Lanczos from a fixed start: its step is never below the true limit and above it
/// by less than a per cent in practice (take a margin). {0, 0} without free nodes or without forces.
FastestMode fastest_mode(const DeformableModel& model, const State& state);

}  // namespace kt
