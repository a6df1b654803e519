#include "core/global/integrator.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/linear/free_dofs.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {

#define INTEGRATOR(name, available, option, what) \
  std::unique_ptr<Integrator> make_##name##_integrator(const IntegratorOptions& options);
#include "core/global/integrators.def"

std::vector<BackendInfo> integrator_backends() {
  return {
#define INTEGRATOR(name, available, option, what) {#name, what, available != 0, option},
#include "core/global/integrators.def"
  };
}

std::unique_ptr<Integrator> make_integrator(const std::string& name, const IntegratorOptions& options) {
#define INTEGRATOR(known, available, option, what) \
  if (name == #known) return make_##known##_integrator(options);
#include "core/global/integrators.def"
  require_backend("integrator", name, integrator_backends());
  return nullptr;
}

namespace {

/// Mass of the free nodes [kg]: what it weighs and its inverse, with or without off-diagonal entries.
class FreeMass {
 public:
  explicit FreeMass(SparseMatrix mass) : mass_(std::move(mass)) {
    if (mass_.nonZeros() == mass_.rows()) return;
    solver_ = make_sparse_solver();
    if (!solver_->factor(mass_)) throw RunError("fastest mode: the mass matrix is not positive definite");
  }
  VectorX times(const VectorX& v) const { return mass_ * v; }
  VectorX inverse_times(const VectorX& f) const {
    return solver_ ? VectorX(solver_->solve(f)) : VectorX(f.cwiseQuotient(VectorX(mass_.diagonal())));
  }

 private:
  SparseMatrix mass_;
  std::unique_ptr<SparseSolver> solver_;
};

/// The u with u^T M u = 1 and the largest u^T A u, by Lanczos; A (n x n) symmetric positive semidefinite.
VectorX dominant_mode(const SparseMatrix& A, const FreeMass& mass) {
  constexpr Eigen::Index kMostSteps = 40;
  const Eigen::Index n = A.rows(), steps = std::min(n, kMostSteps);
  MatrixX basis(n, steps);
  VectorX diagonal(steps), below(steps);
  VectorX u(n);  // a start with all signs and no symmetry
  for (Eigen::Index i = 0; i < n; ++i) u[i] = (i % 2 ? -1.0 : 1.0) * (1.0 + 0.1 * static_cast<double>(i % 7));
  double length = std::sqrt(u.dot(mass.times(u)));
  Eigen::Index used = 0;
  while (used < steps && length > 1e-12 * (used ? diagonal.head(used).maxCoeff() : 0)) {  // else the space is complete
    basis.col(used) = u / length;
    const VectorX Au = A * basis.col(used);
    diagonal[used] = basis.col(used).dot(Au);
    u = mass.inverse_times(Au);
    const auto known = basis.leftCols(++used);
    for (int pass = 0; pass < 2; ++pass) u -= known * (known.transpose() * mass.times(u));  // twice: to roundoff
    length = below[used - 1] = std::sqrt(u.dot(mass.times(u)));
  }
  Eigen::SelfAdjointEigenSolver<MatrixX> small;
  small.computeFromTridiagonal(diagonal.head(used), below.head(used - 1));
  return basis.leftCols(used) * small.eigenvectors().col(used - 1);
}

}  // namespace

FastestMode fastest_mode(const DeformableModel& model, const State& state) {
  const FreeDofs dofs = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
  if (dofs.size() == 0) return {};
  const Tangent tangent = model.tangent(state, TangentKind::definite);
  const SparseMatrix K = gather(dofs, SparseMatrix(-tangent.dfdx)), D = gather(dofs, SparseMatrix(-tangent.dfdv));
  const SparseMatrix M = gather(dofs, model.mass());
  const FreeMass mass(M);
  // Quotients of some motion give a first h; then u maximizes h^2 k + 2 h d and its own quotients give the next h:
  // Newton's iteration on a convex function, which ends from any start.
  double k = VectorX(K.diagonal()).cwiseQuotient(VectorX(M.diagonal())).maxCoeff();
  double d = VectorX(D.diagonal()).cwiseQuotient(VectorX(M.diagonal())).maxCoeff();
  for (int round = 0; round < 4 && k + d > 0; ++round) {
    const double h = 2 / (std::sqrt(k + d * d / 4) + d / 2);
    const VectorX u = dominant_mode(h * h * K + 2 * h * D, mass);
    k = std::max(0.0, u.dot(K * u));
    d = std::max(0.0, u.dot(D * u));
  }
  if (k + d <= 0) return {};
  const double omega = std::max(std::sqrt(k), 1e-8 * d);  // damping without stiffness: the limit of a vanishing one
  return {omega, d / (2 * omega)};
}

}  // namespace kt
