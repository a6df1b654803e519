// (M - dt dfdv - dt^2 dfdx) dv = dt (f + external + dt dfdx v);  v += dv;  x += dt v.
// One linearized step per dt (Baraff and Witkin 1998). Uses the definite tangent: the system stays solvable under any
// compression, and the force itself is exact, so that equilibria are those of the model.
#include <limits>

#include "core/free_dofs.hpp"
#include "core/integrator.hpp"
#include "core/sparse_solver.hpp"

namespace kt {
namespace {

class ImplicitEuler final : public Integrator {
 public:
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    if (dofs_.to_free.empty()) dofs_ = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
    const Tangent tangent = model.tangent(state, TangentKind::definite);
    model.force(state, force_);
    const VectorX rhs = dt * gather(dofs_, VectorX(force_ + external + dt * (tangent.dfdx * state.v)));
    const SparseMatrix system =
        gather(dofs_, SparseMatrix(model.mass() - dt * tangent.dfdv - (dt * dt) * tangent.dfdx));
    if (dofs_.size() > 0 && !solver_->factor(system))
      throw RunError(text("implicit_euler: the step's matrix is not positive definite at t = ", state.t, " s"));
    const VectorX dv = dofs_.size() > 0 ? VectorX(solver_->solve(rhs)) : rhs;  // none free: nothing to solve
    for (int i = 0; i < dofs_.size(); ++i) {
      const int k = dofs_.to_all[i];
      state.v[k] += dv[i];
      state.x[k] += dt * state.v[k];
    }
    state.t += dt;
  }
  double stable_step(const FastestMode&) const override { return std::numeric_limits<double>::infinity(); }

 private:
  FreeDofs dofs_;
  VectorX force_;
  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler_integrator() { return std::make_unique<ImplicitEuler>(); }

}  // namespace kt
