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
    if (!matrix_) prepare(model);
    model.force(state, force_);
    ++statistics_.iterations;
    if (options_.definite) {
      if (!solve(model, external, dt, state, TangentKind::definite)) fail(state);
    } else if (!solve(model, external, dt, state, TangentKind::exact)) {
      ++statistics_.projected;
      if (!solve(model, external, dt, state, TangentKind::definite)) fail(state);
    }
    const FreeDofs& dofs = matrix_->dofs();
    for (int i = 0; i < dofs.size(); ++i) {
      const int k = dofs.to_all[i];
      state.v[k] += change_[i];
      state.x[k] += dt * state.v[k];
    }
    state.t += dt;
  }
  double stable_step(const FastestMode&) const override { return std::numeric_limits<double>::infinity(); }
  StepStatistics statistics() const override { return statistics_; }

 private:
  void prepare(const DeformableModel& model) {
    matrix_ = std::make_unique<StepMatrix>(make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes()));
    solver_ = make_step_solver(options_.solver, {free_positions(model, matrix_->dofs()), options_.tolerance});
  }
  bool solve(const DeformableModel& model, const VectorX& external, double dt, const State& state, TangentKind kind) {
    if (matrix_->dofs().size() == 0) return true;  // none free: nothing to solve
    model.update_tangent(state, kind, tangent_);
    const VectorX rhs = dt * gather(matrix_->dofs(), VectorX(force_ + external + dt * (tangent_.dfdx * state.v)));
    const SparseMatrix& sum = matrix_->sum({{{1, &model.mass()}, {-dt, &tangent_.dfdv}, {-dt * dt, &tangent_.dfdx}}});
    const bool good = solver_->solve(sum, rhs, change_);
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
  VectorX force_, change_;  // change of v: the guess of the next one
  StepStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler_integrator(const IntegratorOptions& options) {
  return std::make_unique<ImplicitEuler>(options);
}

}  // namespace kt
