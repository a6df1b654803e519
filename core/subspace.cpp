#include "core/subspace.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <numbers>

#include "core/error.hpp"

namespace kt {
namespace {

constexpr double kProportional = 1e-9;  // off the diagonal, of the damping between two vibrations

SparseMatrix symmetric_part(const SparseMatrix& m) { return 0.5 * (m + SparseMatrix(m.transpose())); }

/// Diagonal where the rest is roundoff.
SparseMatrix sparse_of(const MatrixX& m) {
  const VectorX scale = m.diagonal().cwiseAbs().cwiseSqrt();
  std::vector<Eigen::Triplet<double>> entries;
  bool diagonal = true;
  for (int c = 0; c < m.cols(); ++c)
    for (int r = 0; r < m.rows(); ++r) diagonal &= r == c || std::abs(m(r, c)) <= kProportional * scale[r] * scale[c];
  for (int c = 0; c < m.cols(); ++c)
    for (int r = 0; r < m.rows(); ++r)
      if (r == c || !diagonal) entries.emplace_back(r, c, 0.5 * (m(r, c) + m(c, r)));
  SparseMatrix out(m.rows(), m.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// B^T-weighted by a diagonal W > 0: W^-1 B^T (B W^-1 B^T)^-1 on the rows of B that are not zero.
SparseMatrix right_inverse(const MatrixX& B, const VectorX& weight) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    if (!B.row(i).isZero(0)) rows.push_back(i);
  const MatrixX moving = B(rows, Eigen::all);
  const MatrixX eased = weight.cwiseInverse().asDiagonal() * moving.transpose();
  const Eigen::LDLT<MatrixX> response(moving * eased);
  MatrixX out = MatrixX::Zero(B.cols(), B.rows());
  out(Eigen::all, rows) = response.solve(eased.transpose()).transpose();
  return out.sparseView(1, 0);
}

}  // namespace

FreeBody::FreeBody(const TangentModel& tangent)
    : dofs(make_free_dofs(static_cast<int>(tangent.f0.size()) / 3, tangent.fixed_nodes)),
      mass(gather(dofs, tangent.mass)),
      damping(-symmetric_part(gather(dofs, tangent.dfdv))),
      stiffness(-symmetric_part(gather(dofs, tangent.dfdx))),
      force(gather(dofs, VectorX(tangent.f0 - tangent.dfdv * tangent.state.v))),
      velocity(gather(dofs, tangent.state.v)) {}

MatrixX FreeBody::inputs(const SurfacePatch& patch) const {
  std::vector<int> entries;
  for (int i : patch.global_node)
    for (int c = 0; c < 3; ++c)
      if (const int k = dofs.to_free[3 * i + c]; k >= 0) entries.push_back(k);
  MatrixX out = MatrixX::Zero(dofs.size(), static_cast<Eigen::Index>(entries.size()));
  for (std::size_t j = 0; j < entries.size(); ++j) out(entries[j], static_cast<Eigen::Index>(j)) = 1;
  return out;
}

MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts) {
  MatrixX loads = body.inputs(patch);
  const Eigen::Index columns = loads.cols() + 1;
  loads.conservativeResize(Eigen::NoChange, columns);
  loads.col(columns - 1) = body.force;
  MatrixX out(loads.rows(), columns * static_cast<Eigen::Index>(shifts.size()) + 1);
  out.rightCols(1) = body.velocity;
  const auto solver = make_sparse_solver();
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const double s = 2 * std::numbers::pi * shifts[i], s_free = 2 * std::numbers::pi;
    bool good = solver->factor(SparseMatrix(s * s * body.mass + s * body.damping + body.stiffness));
    if (!good && s == 0) good = solver->factor(SparseMatrix(s_free * s_free * body.mass + body.stiffness));
    if (!good) throw IndefiniteBody("reducer: the body's stiffness is not positive definite");
    out.middleCols(static_cast<Eigen::Index>(i) * columns, columns) = solver->solve(loads);
  }
  return out;
}

MatrixX orthonormal_motions(const SparseMatrix& mass, MatrixX motions, double tolerance) {
  // Twice: the first pass loses half of the digits of directions that nearly coincide (Cholesky QR 2, Yamamoto et al.
  // 2015, with eigenvectors for the factor, which reveal the rank).
  for (int pass = 0; pass < 2; ++pass) {
    const VectorX length = (motions.cwiseProduct(mass * motions)).colwise().sum().cwiseSqrt();
    for (Eigen::Index c = 0; c < motions.cols(); ++c)
      if (length[c] > 0) motions.col(c) /= length[c];
    const MatrixX gram = motions.transpose() * (mass * motions);
    const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(gram);
    const VectorX& values = eigen.eigenvalues();  // ascending
    const double least = std::max(1e-14, tolerance * tolerance) * values[values.size() - 1];
    Eigen::Index drop = 0;
    while (drop < values.size() && !(values[drop] > least)) ++drop;
    const Eigen::Index keep = values.size() - drop;
    motions = motions * (eigen.eigenvectors().rightCols(keep) *
                         values.tail(keep).cwiseSqrt().cwiseInverse().asDiagonal());
  }
  return motions;
}

LocalModel confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch patch, const MatrixX& V) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(V.transpose() * (body.stiffness * V));
  const MatrixX motions = V * eigen.eigenvectors();
  const int r = static_cast<int>(motions.cols()), p = patch.num_vertices();

  LocalModel out;
  out.t = tangent.state.t;
  out.mass = SparseMatrix(VectorX::Ones(r).asDiagonal());
  // Rounded below zero only where the body itself is free to move.
  out.stiffness = SparseMatrix(VectorX(eigen.eigenvalues().cwiseMax(0)).asDiagonal());
  out.damping = sparse_of(motions.transpose() * (body.damping * motions));
  out.f0 = motions.transpose() * body.force;

  MatrixX basis = MatrixX::Zero(3 * p, r);
  out.x0.resize(3 * p);
  out.v0.resize(3 * p);
  for (int i = 0; i < p; ++i) {
    const int g = patch.global_node[i];
    node(out.x0, i) = node(tangent.state.x, g);
    for (int c = 0; c < 3; ++c) {
      const int k = body.dofs.to_free[3 * g + c];
      out.v0[3 * i + c] = k < 0 ? 0 : tangent.state.v[3 * g + c];
      if (k >= 0) basis.row(3 * i + c) = motions.row(k);
    }
  }
  out.basis = basis.sparseView(1, 0);
  // A millionth of the stiffest: a body that is free to move follows too.
  const VectorX springs = eigen.eigenvalues().cwiseMax(1e-12 * eigen.eigenvalues().maxCoeff());
  out.lift = right_inverse(basis, springs);
  out.lift_rate = right_inverse(basis, VectorX::Ones(r));
  out.q_rate0 = motions.transpose() * (body.mass * body.velocity);
  out.recovered_node = patch.global_node;
  out.patch = std::move(patch);
  return out;
}

}  // namespace kt
