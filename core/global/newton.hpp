#pragma once
// The nonlinear equations of implicit steps and of equilibria, by Newton's method with a line search.
#include <limits>
#include <memory>

#include "core/global/integrator.hpp"
#include "core/linear/step_matrix.hpp"
#include "core/linear/step_solver.hpp"

namespace kt {

/// One implicit step: find v with  M (v - v_start) = a (f(x, v) + external),  x = x_start + a v.
/// Backward Euler: the state before and a = dt. Equilibrium (no mass, f at rest): f(x, 0) + external = 0, a = 1.
struct ImplicitStage {
  VectorX x_start, v_start;
  double a = 0;  ///< [s]
  bool is_static = false;
};

class NewtonSolver {
 public:
  explicit NewtonSolver(IntegratorOptions options) : options_(std::move(options)) {}

  /// Moves `state` (its v is the guess; fixed nodes stay) to the solution, to `convergence` of the body's size or as
  /// near as 50 iterations get. The exact tangent, or the definite one when that is not positive definite. Throws
  /// RunError when neither can be solved with.
  void solve(const DeformableModel& model, const VectorX& external, const ImplicitStage& stage, State& state);

  const StepStatistics& statistics() const { return statistics_; }

 private:
  VectorX residual(const DeformableModel& model, const VectorX& external, const ImplicitStage& stage, const VectorX& v,
                   State& state) const;
  void find_direction(const DeformableModel& model, const ImplicitStage& stage, const State& state,
                      const VectorX& residual, VectorX& direction);
  IntegratorOptions options_;
  std::unique_ptr<StepMatrix> matrix_;
  std::unique_ptr<StepSolver> solver_;
  StepStatistics statistics_;
  Tangent tangent_;
};

/// What integrators by Newton's method share.
class NewtonIntegrator : public Integrator {
 public:
  double stable_step(const FastestMode&) const override { return std::numeric_limits<double>::infinity(); }
  StepStatistics statistics() const override { return newton_.statistics(); }

 protected:
  explicit NewtonIntegrator(const IntegratorOptions& options) : newton_(options) {}
  NewtonSolver newton_;
};

/// Rest positions of the free nodes, (3 free): how the system of a step can move as a rigid body.
VectorX free_positions(const DeformableModel& model, const FreeDofs& dofs);

}  // namespace kt
