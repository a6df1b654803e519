// v += dt M^-1 f(x, v);  x += dt v.                                                               Paper eq. (11).
//
// Stable step: the scalar motion x'' = -w^2 x - 2 z w x' gives, with g the growth of one step, g^2 - (2 - 2 z w dt -
// (w dt)^2) g + (1 - 2 z w dt) = 0. Its roots leave the unit disk first at g = -1, where (w dt)^2 + 4 z w dt = 4, so
// w dt < 2 (sqrt(1 + z^2) - z) = 2 / (sqrt(1 + z^2) + z).
#include <cmath>
#include <limits>

#include "core/global/integrator.hpp"
#include "core/linear/free_dofs.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

class SymplecticEuler final : public Integrator {
 public:
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override {
    if (dofs_.to_free.empty()) prepare(model);
    model.force(state, force_);
    force_ += external;
    const VectorX free = gather(dofs_, force_);
    const VectorX acceleration = solver_ ? VectorX(solver_->solve(free)) : VectorX(free.cwiseQuotient(diagonal_));
    for (int i = 0; i < dofs_.size(); ++i) {
      const int k = dofs_.to_all[i];
      state.v[k] += dt * acceleration[i];
      state.x[k] += dt * state.v[k];
    }
    state.t += dt;
  }
  double stable_step(const FastestMode& mode) const override {
    if (!(mode.omega > 0)) return std::numeric_limits<double>::infinity();
    return 2 / (mode.omega * (std::sqrt(1 + mode.zeta * mode.zeta) + mode.zeta));
  }

 private:
  void prepare(const DeformableModel& model) {
    dofs_ = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
    const SparseMatrix mass = gather(dofs_, model.mass());
    const bool is_diagonal = mass.nonZeros() == mass.rows();
    if (is_diagonal) {
      diagonal_ = mass.diagonal();
    } else {
      solver_ = make_sparse_solver();
      if (!solver_->factor(mass)) throw RunError("symplectic_euler: the mass matrix is not positive definite");
    }
  }
  FreeDofs dofs_;
  VectorX diagonal_, force_;
  std::unique_ptr<SparseSolver> solver_;
};

}  // namespace

std::unique_ptr<Integrator> make_symplectic_euler_integrator(const IntegratorOptions&) {
  return std::make_unique<SymplecticEuler>();
}

}  // namespace kt
