#include "core/integrator.hpp"

#include <cmath>

#include "core/free_dofs.hpp"

namespace kt {

#define INTEGRATOR(name, available, option, what) std::unique_ptr<Integrator> make_##name##_integrator();
#include "core/integrators.def"
#undef INTEGRATOR

std::vector<BackendInfo> integrator_backends() {
  return {
#define INTEGRATOR(name, available, option, what) {#name, what, available != 0, option},
#include "core/integrators.def"
#undef INTEGRATOR
  };
}

std::unique_ptr<Integrator> make_integrator(const std::string& name) {
#define INTEGRATOR(known, available, option, what) \
  if (name == #known) return make_##known##_integrator();
#include "core/integrators.def"
#undef INTEGRATOR
  require_backend("integrator", name, integrator_backends());
  return nullptr;
}

double highest_frequency(const DeformableModel& model, const State& state) {
  constexpr int kIterations = 60;
  const FreeDofs dofs = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
  if (dofs.size() == 0) return 0;
  const SparseMatrix stiffness = gather(dofs, SparseMatrix(-model.tangent(state, TangentKind::definite).dfdx));
  const VectorX mass = gather(dofs, model.mass()).diagonal();
  // Power iteration on the symmetric M^-1/2 K M^-1/2 with a start that has all signs.
  const VectorX scale = mass.cwiseSqrt().cwiseInverse();
  VectorX u(dofs.size());
  for (int i = 0; i < u.size(); ++i) u[i] = (i % 2 ? -1.0 : 1.0) * (1.0 + 0.1 * (i % 7));
  double omega_sq = 0;
  for (int i = 0; i < kIterations; ++i) {
    u.normalize();
    VectorX next = scale.cwiseProduct(stiffness * scale.cwiseProduct(u));
    omega_sq = u.dot(next);
    u = std::move(next);
    if (u.norm() == 0) break;
  }
  return std::sqrt(std::max(0.0, omega_sq));
}

}  // namespace kt
