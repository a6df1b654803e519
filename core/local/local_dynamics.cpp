#include "core/local/local_dynamics.hpp"

#include <Eigen/Cholesky>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/base/error.hpp"
#include "core/linear/dense/dense_cholesky.hpp"
#include "core/linear/dense/dense_product.hpp"
#include "core/local/damping.hpp"

namespace kt {
namespace {

// Up to here one dense matrix-vector product beats two sparse triangular solves (measured in bench/).
constexpr int kDenseLimit = 450;

using SparseCholesky = Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower>;

[[noreturn]] void throw_indefinite() { throw RunError("the local model's step matrix is not positive definite"); }

void require_success(const SparseCholesky& llt) {
  if (llt.info() != Eigen::Success) throw_indefinite();
}

bool is_mostly_full(const SparseMatrix& m) { return 2 * m.nonZeros() > m.rows() * m.cols(); }

/// The rows of the patch, and how contact impulses act: their transpose.
struct PatchBasis {
  explicit PatchBasis(const LocalModel& model)
      : sparse(model.basis.topRows(3 * model.patch.num_vertices())),
        inputs(sparse.transpose()),
        is_full(is_mostly_full(sparse)) {}

  /// Y = A^-1 B^T for a symmetric A^-1, and so C = B Y.
  Response response(MatrixX Y) const {
    MatrixX C = is_full ? symmetric_product(inputs, RowMatrix(Y)) : MatrixX(sparse * Y);
    return {std::move(Y), std::move(C)};
  }
  /// @param inverse_factor  L^-1 of A = L L^T
  Response response_of(const RowMatrix& inverse_factor) const {
    const RowMatrix half = tall_product(inverse_factor, inputs);
    return {tall_product(inverse_factor.transpose(), half), symmetric_product(half, half)};
  }

  SparseMatrix sparse;
  RowMatrix inputs;  // (r x 3p)
  bool is_full;
};

RowMatrix require_factor(const SparseMatrix& A) {
  std::optional<RowMatrix> inverse = inverse_factor(MatrixX(A));
  if (!inverse) throw_indefinite();
  return std::move(*inverse);
}

}  // namespace

bool is_uncoupled(const LocalModel& model) {
  return is_diagonal(model.mass) && is_diagonal(model.damping) && is_diagonal(model.stiffness);
}

LocalDynamics::LocalDynamics(const LocalModel& model, LocalScheme scheme, Metric metric, double h)
    : model_(model), scheme_(scheme), h_(h), rhs_(model.dof()), permuted_(model.dof()) {
  const bool uncoupled = is_uncoupled(model);
  if (scheme == LocalScheme::exact && !uncoupled)
    throw InputError(text("local.integrator exact: the vibrations of local.reducer ", model.reducer,
                          " are coupled by their damping or are none; use implicit_euler"));
  const PatchBasis basis(model);
  const RowMatrix& inputs = basis.inputs;
  const SparseMatrix implicit = model.mass + h * model.damping + (h * h) * model.stiffness;
  const SparseMatrix& A = scheme == LocalScheme::symplectic_euler ? model.mass : implicit;

  SparseCholesky llt;
  if (uncoupled) {
    make_vibrations();
    inertia_ = basis.response((vibrations_.mean_force / h).asDiagonal() * inputs);
  } else if (is_diagonal(A)) {
    diagonal_inverse_ = VectorX(A.diagonal()).cwiseInverse();
    inertia_ = basis.response(diagonal_inverse_.asDiagonal() * inputs);
  } else if (is_mostly_full(A) && model.dof() <= kDenseLimit) {
    const RowMatrix inverse = require_factor(A);
    inertia_ = basis.response_of(inverse);
    dense_inverse_ = PanelMatrix(inverse_from(inverse));
  } else {
    llt.compute(A);
    require_success(llt);
    inertia_ = basis.response(llt.solve(MatrixX(inputs)));
    if (model.dof() <= kDenseLimit) {
      dense_inverse_ = PanelMatrix(llt.solve(MatrixX::Identity(model.dof(), model.dof())));
    } else {
      lower_ = llt.matrixL();
      permutation_ = llt.permutationP().indices();
    }
  }

  if (metric == Metric::identity) {
    const MatrixX lift = model.lift_rate.leftCols(inputs.cols());
    metric_ = {lift, basis.sparse * lift};
  } else {
    const Metric own = scheme == LocalScheme::symplectic_euler ? Metric::mass : Metric::implicit;
    metric_is_inertia_ = metric == own;
    if (!metric_is_inertia_) {
      const SparseMatrix& other = metric == Metric::implicit ? implicit : model.mass;
      if (is_mostly_full(other) && model.dof() <= kDenseLimit) {
        metric_ = basis.response_of(require_factor(other));
      } else {
        llt.compute(other);
        require_success(llt);
        metric_ = basis.response(llt.solve(MatrixX(inputs)));
      }
    } else if (scheme == LocalScheme::exact) {
      end_response_ = (vibrations_.end_force / h).asDiagonal() * inputs;
      kick_ = basis.response(VectorX(model.mass.diagonal()).cwiseInverse().asDiagonal() * inputs);
    }
  }
}

void LocalDynamics::make_vibrations() {
  const VectorX m = model_.mass.diagonal(), d = model_.damping.diagonal(), k = model_.stiffness.diagonal();
  if (!(m.array() > 0).all()) throw RunError("the local model's step matrix is not positive definite");
  Vibrations& v = vibrations_;
  v.mean_q = v.mean_rate = v.mean_force = v.end_q = v.end_rate = v.end_force = VectorX(m.size());
  for (int i = 0; i < m.size(); ++i) {
    if (scheme_ == LocalScheme::exact) {
      make_exact(m[i], d[i], k[i], i);
      continue;
    }
    const bool is_implicit = scheme_ == LocalScheme::implicit_euler;
    const double a = is_implicit ? m[i] + h_ * d[i] + h_ * h_ * k[i] : m[i];
    v.mean_q[i] = v.end_q[i] = -h_ * k[i] / a;
    v.mean_rate[i] = v.end_rate[i] = is_implicit ? m[i] / a : 1 - h_ * d[i] / a;
    v.mean_force[i] = v.end_force[i] = h_ / a;
  }
}

/// The exponential of (q, q', force)' = [q', (force - k q - d q') / m, 0] over the step (Van Loan 1978).
void LocalDynamics::make_exact(double mass, double damping, double stiffness, int i) {
  Mat3 generator;
  generator << 0, 1, 0, -stiffness / mass, -damping / mass, 1 / mass, 0, 0, 0;
  const Mat3 step = (h_ * generator).exp();
  Vibrations& v = vibrations_;
  v.mean_q[i] = (step(0, 0) - 1) / h_;
  v.mean_rate[i] = step(0, 1) / h_;
  v.mean_force[i] = step(0, 2) / h_;
  v.end_q[i] = step(1, 0);
  v.end_rate[i] = step(1, 1);
  v.end_force[i] = step(1, 2);
}

void LocalDynamics::solve(VectorX& b) const noexcept {
  if (diagonal_inverse_.size()) {
    b.array() *= diagonal_inverse_.array();
  } else if (!dense_inverse_.empty()) {
    permuted_ = b;
    dense_inverse_.multiply(permuted_, b);
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

void LocalDynamics::free_motion(const VectorX& q, const VectorX& q_rate, VectorX& mean, VectorX& end) const noexcept {
  if (const Vibrations& v = vibrations_; v.mean_q.size()) {
    const auto &f0 = model_.f0.array(), &at = q.array(), &rate = q_rate.array();
    rhs_.array() = v.end_q.array() * at + v.end_rate.array() * rate + v.end_force.array() * f0;
    mean.array() = v.mean_q.array() * at + v.mean_rate.array() * rate + v.mean_force.array() * f0;
    end = rhs_;
    return;
  }
  if (scheme_ == LocalScheme::symplectic_euler) {
    force(q, q_rate, rhs_);
    solve(rhs_);
    mean = q_rate + h_ * rhs_;
  } else {
    mean = model_.f0;
    mean.noalias() -= model_.stiffness * q;
    mean *= h_;
    mean.noalias() += model_.mass * q_rate;
    solve(mean);
  }
  end = mean;
}

}  // namespace kt
