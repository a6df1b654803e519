// (M - dt dfdv - dt^2 dfdx) dv = dt (f + external + dt dfdx v);  v += dv;  x += dt v.
// One linearized step per dt (Baraff and Witkin 1998). By default with the definite tangent: the system stays solvable
// under any compression, and the force itself is exact, so that equilibria are those of the model.
#include <limits>

#include "core/global/newton.hpp"

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
    added_.clear();
    model.added_stiffness(added_);
    update_tangent(model, state, kind);
    const SparseMatrix& sum = matrix_->sum({{{1, &model.mass()}, {-dt, &tangent_.dfdv}, {-dt * dt, &tangent_.dfdx}}});
    const bool is_in_pattern = matrix_->add(-dt * dt, added_);  // else it couples nodes that the body does not
    if (!is_in_pattern) solver_->put_beside(matrix_->of_free_nodes(-dt * dt, added_));
    const VectorX rhs = dt * (gather(matrix_->dofs(), VectorX(force_ + external)) + dt * pull_along(state.v, kind));
    const bool good = (solver_.get()->*solver)(sum, rhs, change);
    statistics_.linear_iterations += solver_->iterations();
    return good;
  }
  /// That of the model's base, which is kept where it lasts: a step begins where the last one was looked ahead from.
  void update_tangent(const DeformableModel& model, const State& state, TangentKind kind) {
    const DeformableModel& base = model.base();
    if (tangent_of_ == &base && kind_ == kind && at_.x == state.x && at_.v == state.v) return;
    base.update_tangent(state, kind, tangent_);
    tangent_of_ = &base == &model ? nullptr : &base;  // a model without a base may be another one at the same place
    at_ = state;
    kind_ = kind;
  }
  /// dfdx v on the free nodes. The definite dfdx is symmetric.
  VectorX pull_along(const VectorX& v, TangentKind kind) const {
    const FreeDofs& dofs = matrix_->dofs();
    VectorX out = kind == TangentKind::definite ? matrix_->symmetric_times(2, tangent_.dfdx, v)
                                                : gather(dofs, VectorX(tangent_.dfdx * v));
    for (const auto& entry : added_)
      if (const int i = dofs.to_free[entry.row()]; i >= 0) out[i] += entry.value() * v[entry.col()];
    return out;
  }
  [[noreturn]] static void fail(const State& state) {
    throw RunError(text(
        "implicit_euler: the step's matrix is not positive definite, or global.solver pcg does not converge, at t = ",
        state.t, " s"));
  }

  IntegratorOptions options_;
  std::unique_ptr<StepMatrix> matrix_;
  std::unique_ptr<StepSolver> solver_;
  std::vector<Eigen::Triplet<double>> added_;  // to the tangent, of the model in hand
  Tangent tangent_;
  const DeformableModel* tangent_of_ = nullptr;  // whose tangent_ it is, at_ this state; none: not kept
  State at_;
  TangentKind kind_ = TangentKind::definite;
  VectorX force_, change_, change_ahead_;  // changes of v: guesses of the next ones
  StepStatistics statistics_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler_integrator(const IntegratorOptions& options) {
  return std::make_unique<ImplicitEuler>(options);
}

}  // namespace kt
