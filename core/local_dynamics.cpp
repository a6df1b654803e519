#include "core/local_dynamics.hpp"

#include <Eigen/Cholesky>

#include "core/error.hpp"

namespace kt {
namespace {

// Up to here one dense matrix-vector product beats two sparse triangular solves (measured in bench/).
constexpr int kDenseLimit = 450;

bool is_diagonal(const SparseMatrix& m) {
  for (int c = 0; c < m.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(m, c); it; ++it)
      if (it.row() != c && it.value() != 0) return false;
  return true;
}

using SparseCholesky = Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower>;

void require_success(const SparseCholesky& llt) {
  if (llt.info() != Eigen::Success) throw RunError("the local model's step matrix is not positive definite");
}

Response make_response(const MatrixX& inverse_times_basis, const SparseMatrix& patch_basis) {
  return {inverse_times_basis, patch_basis * inverse_times_basis};
}

}  // namespace

LocalDynamics::LocalDynamics(const LocalModel& model, LocalScheme scheme, Metric metric, double h)
    : model_(model), scheme_(scheme), h_(h), rhs_(model.dof()), permuted_(model.dof()) {
  const SparseMatrix patch_basis = model.basis.topRows(3 * model.patch.num_vertices());
  const MatrixX inputs = MatrixX(patch_basis.transpose());
  const SparseMatrix implicit = model.mass + h * model.damping + (h * h) * model.stiffness;
  const SparseMatrix& A = scheme == LocalScheme::implicit_euler ? implicit : model.mass;

  SparseCholesky llt;
  if (is_diagonal(A)) {
    diagonal_inverse_ = VectorX(A.diagonal()).cwiseInverse();
    inertia_ = make_response(diagonal_inverse_.asDiagonal() * inputs, patch_basis);
  } else {
    llt.compute(A);
    require_success(llt);
    inertia_ = make_response(llt.solve(inputs), patch_basis);
    if (model.dof() <= kDenseLimit) {
      dense_inverse_ = llt.solve(MatrixX::Identity(model.dof(), model.dof()));
    } else {
      lower_ = llt.matrixL();
      permutation_ = llt.permutationP().indices();
    }
  }

  if (metric == Metric::identity) {
    metric_ = make_response(MatrixX(model.lift_rate.leftCols(inputs.cols())), patch_basis);
  } else {
    const Metric own = scheme == LocalScheme::implicit_euler ? Metric::implicit : Metric::mass;
    metric_is_inertia_ = metric == own;
    if (!metric_is_inertia_) {
      llt.compute(metric == Metric::implicit ? implicit : model.mass);
      require_success(llt);
      metric_ = make_response(llt.solve(inputs), patch_basis);
    }
  }
}

void LocalDynamics::solve(VectorX& b) const noexcept {
  if (diagonal_inverse_.size()) {
    b.array() *= diagonal_inverse_.array();
  } else if (dense_inverse_.size()) {
    permuted_ = b;
    b.noalias() = dense_inverse_ * permuted_;
  } else {
    for (int i = 0; i < b.size(); ++i) permuted_[permutation_[i]] = b[i];
    lower_.triangularView<Eigen::Lower>().solveInPlace(permuted_);
    lower_.transpose().triangularView<Eigen::Upper>().solveInPlace(permuted_);
    for (int i = 0; i < b.size(); ++i) b[i] = permuted_[permutation_[i]];
  }
}

void LocalDynamics::force(const VectorX& q, const VectorX& q_rate, VectorX& out) const noexcept {
  out = model_.f0;
  out.noalias() -= model_.stiffness * q;
  out.noalias() -= model_.damping * q_rate;
}

void LocalDynamics::free_velocity(const VectorX& q, const VectorX& q_rate, VectorX& out) const noexcept {
  if (scheme_ == LocalScheme::symplectic_euler) {
    force(q, q_rate, rhs_);
    solve(rhs_);
    out = q_rate + h_ * rhs_;
    return;
  }
  out = model_.f0;
  out.noalias() -= model_.stiffness * q;
  out *= h_;
  out.noalias() += model_.mass * q_rate;
  solve(out);
}

}  // namespace kt
