#include "lab/stability/runs/condition.hpp"

#include <limits>

#include "core/linear/free_dofs.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

/// Largest eigenvalue of a symmetric positive definite map.
template <class Map>
double dominant(Eigen::Index size, const Map& times) {
  constexpr int kMostRounds = 100;
  VectorX u(size);
  for (Eigen::Index i = 0; i < size; ++i) u[i] = (i % 2 ? -1.0 : 1.0) * (1.0 + 0.1 * static_cast<double>(i % 7));
  double value = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const double before = value;
    u.normalize();
    const VectorX next = times(u);
    value = u.dot(next);
    u = next;
    if (value - before < 1e-4 * value) break;
  }
  return value;
}

}  // namespace

double condition_number(const DeformableModel& model) {
  const FreeDofs dofs = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
  const Tangent tangent = model.tangent(rest_state(model), TangentKind::exact);
  const SparseMatrix K = gather(dofs, SparseMatrix(-tangent.dfdx));
  const auto solver = make_sparse_solver();
  if (!solver->factor(K)) return std::numeric_limits<double>::infinity();
  return dominant(dofs.size(), [&](const VectorX& u) { return VectorX(K * u); }) *
         dominant(dofs.size(), [&](const VectorX& u) { return VectorX(solver->solve(u)); });
}

}  // namespace kt
