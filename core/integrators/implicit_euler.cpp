// (M - dt dfdv - dt^2 dfdx) dv = dt (f + external + dt dfdx v);  v += dv;  x += dt v.
// One linearized step per dt (Baraff and Witkin 1998). By default with the definite tangent: the system stays solvable
// under any compression, and the force itself is exact, so that equilibria are those of the model.
#include <limits>

#include "core/newton.hpp"

namespace kt {
namespace {

class ImplicitEuler final : public Integrator {
 public:
  explicit ImplicitEuler(IntegratorOptions options) : options_(std::move(options)) {}

  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    take_step(model, external, dt, state, change_, &StepSolver::solve);
  }
  void look_ahead(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    take_step(model, external, dt, state, change_ahead_, &StepSolver::solve_roughly);
  }
  double stable_step(const FastestMode&) const override { return std::numeric_limits<double>::infinity(); }
  StepStatistics statistics() const override { return statistics_; }

 private:
  using Solve = bool (StepSolver::*)(const SparseMatrix&, const VectorX&, VectorX&);

  /// @param change  of v: of the last such step, then of this one
  void take_step(const DeformableModel& model, const VectorX& external, double dt, State& state, VectorX& change,
                 Solve solver) {
    if (!matrix_) prepare(model);
    model.force(state, force_);
    ++statistics_.iterations;
    if (options_.definite) {
      if (!solve(model, external, dt, state, TangentKind::definite, change, solver)) fail(state);
    } else if (!solve(model, external, dt, state, TangentKind::exact, change, solver)) {
      ++statistics_.projected;
      if (!solve(model, external, dt, state, TangentKind::definite, change, solver)) fail(state);
    }
    const FreeDofs& dofs = matrix_->dofs();
    for (int i = 0; i < dofs.size(); ++i) {
      const int k = dofs.to_all[i];
      state.v[k] += change[i];
      state.x[k] += dt * state.v[k];
    }
    state.t += dt;
  }
  void prepare(const DeformableModel& model) {
    matrix_ = std::make_unique<StepMatrix>(make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes()));
    solver_ = make_step_solver(options_.solver, {free_positions(model, matrix_->dofs()), options_.tolerance});
  }
  bool solve(const DeformableModel& model, const VectorX& external, double dt, const State& state, TangentKind kind,
             VectorX& change, Solve solver) {
    if (matrix_->dofs().size() == 0) return true;  // none free: nothing to solve
    model.update_tangent(state, kind, tangent_);
    const SparseMatrix& sum = matrix_->sum({{{1, &model.mass()}, {-dt, &tangent_.dfdv}, {-dt * dt, &tangent_.dfdx}}});
    // The definite dfdx is symmetric.
    const VectorX pull = kind == TangentKind::definite ? matrix_->symmetric_times(2, tangent_.dfdx, state.v)
                                                       : gather(matrix_->dofs(), VectorX(tangent_.dfdx * state.v));
    const VectorX rhs = dt * (gather(matrix_->dofs(), VectorX(force_ + external)) + dt * pull);
    const bool good = (solver_.get()->*solver)(sum, rhs, change);
    statistics_.linear_iterations += solver_->iterations();
    return good;
  }
  [[noreturn]] static void fail(const State& state) {
    throw RunError(text(
        "implicit_euler: the step's matrix is not positive definite, or global.solver pcg does not converge, at t = ",
        state.t, " s"));
  }

  IntegratorOptions options_;
  std::unique_ptr<StepMatrix> matrix_;
  std::unique_ptr<StepSolver> solver_;
  Tangent tangent_;
  VectorX force_, change_, change_ahead_;  // changes of v: guesses of the next ones
  StepStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler_integrator(const IntegratorOptions& options) {
  return std::make_unique<ImplicitEuler>(options);
}

}  // namespace kt
