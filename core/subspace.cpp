#include "core/subspace.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <numbers>

#include "core/error.hpp"
#include "core/far_motions.hpp"
#include "core/sparse_product.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-10;     // of the largest spring: less is no instability
constexpr double kProportional = 1e-9;  // off the diagonal, of the damping between two vibrations
constexpr double kOnePass = 1e-5;       // [-] rank tolerance that one orthonormalization is good for
constexpr double kAnswered = 1e-3;      // [-] of a load: a good factor leaves a millionth of it
constexpr double kFirmness = 100;       // how much longer than the others firm motions count
constexpr double kSoftest = 1e-9;       // of the largest spring: what a motion without one is given to follow others
constexpr double kYield = 1e-3;         // [-] of what a node gives way alone, all else held

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

/// Of the rows of B that are in reach and not zero, W > 0 diagonal, R = B W^-1 B^T, `own` > 0 what each node resists
/// with itself: W^-1 B^T R^-1; and the same with R + kYield / own, as if each node were pulled by springs (or masses).
/// The latter as (W + B^T K B)^-1 B^T K with K = own / kYield: R loses all of it beside a motion that hardly anything
/// resists.
struct Inverses {
  SparseMatrix exact, yielding;
};

Inverses right_inverses(const MatrixX& B, const VectorX& weight, const VectorX& own,
                        const std::vector<char>& in_reach) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    if (in_reach[static_cast<std::size_t>(i / 3)] && !B.row(i).isZero(0)) rows.push_back(i);
  const MatrixX moving = B(rows, Eigen::all);
  const MatrixX eased = weight.cwiseInverse().asDiagonal() * moving.transpose();
  const MatrixX response = moving * eased;
  MatrixX out = MatrixX::Zero(B.cols(), B.rows());
  Inverses both;
  out(Eigen::all, rows) = response.ldlt().solve(eased.transpose()).transpose();
  both.exact = out.sparseView(1, 0);
  const MatrixX pulled = (own(rows) / kYield).asDiagonal() * moving;
  MatrixX resisted = weight.asDiagonal();
  resisted.noalias() += moving.transpose() * pulled;
  out(Eigen::all, rows) = MatrixX(resisted.llt().solve(pulled.transpose()));
  both.yielding = out.sparseView(1, 0);
  return both;
}

}  // namespace

FreeBody::FreeBody(const TangentModel& tangent)
    : dofs(make_free_dofs(static_cast<int>(tangent.f0.size()) / 3, tangent.fixed_nodes)),
      mass(gather(dofs, tangent.mass)),
      damping(-symmetric_part(gather(dofs, tangent.dfdv))),
      stiffness(-symmetric_part(gather(dofs, tangent.dfdx))),
      force(gather(dofs, VectorX(tangent.f0 - tangent.dfdv * tangent.state.v))),
      velocity(gather(dofs, tangent.state.v)),
      x(tangent.state.x) {}

MatrixX FreeBody::inputs(const SurfacePatch& patch, bool with_rim) const {
  std::vector<int> entries;
  for (const bool in_reach : {true, false})
    for (int i = 0; i < patch.num_vertices(); ++i)
      for (int c = 0; (in_reach || with_rim) && static_cast<bool>(patch.in_reach[i]) == in_reach && c < 3; ++c)
        if (const int k = dofs.to_free[3 * patch.global_node[i] + c]; k >= 0) entries.push_back(k);
  MatrixX out = MatrixX::Zero(force.size(), static_cast<Eigen::Index>(entries.size()));
  for (std::size_t j = 0; j < entries.size(); ++j) out(entries[j], static_cast<Eigen::Index>(j)) = 1;
  return out;
}

SparseMatrix dynamic_stiffness(const FreeBody& body, double s) {
  const SparseMatrix &m = body.mass, &d = body.damping, &k = body.stiffness;
  const auto same_pattern = [&](const SparseMatrix& o) {
    return o.nonZeros() == k.nonZeros() &&
           std::equal(o.innerIndexPtr(), o.innerIndexPtr() + o.nonZeros(), k.innerIndexPtr()) &&
           std::equal(o.outerIndexPtr(), o.outerIndexPtr() + o.cols() + 1, k.outerIndexPtr());
  };
  if (!same_pattern(m) || !same_pattern(d)) return s * s * m + s * d + k;
  SparseMatrix out = k;
  for (Eigen::Index i = 0; i < out.nonZeros(); ++i) out.valuePtr()[i] += s * s * m.valuePtr()[i] + s * d.valuePtr()[i];
  return out;
}

namespace {

MatrixX beside(const MatrixX& a, const MatrixX& b) {
  MatrixX out(a.rows(), a.cols() + b.cols());
  out << a, b;
  return out;
}

/// False: some motion meets no resistance, and rounding alone made the factorization pass.
bool answers(const FreeBody& body, const SparseSolver& solver) {
  const VectorX load = VectorX::Ones(body.stiffness.rows());
  return (body.stiffness * solver.solve(load) - load).norm() <= kAnswered * load.norm();
}

void factor_at(const FreeBody& body, double hz, SparseSolver& solver) {
  // Of a free body: high enough that its swimming does not outweigh, and so hide, how it yields under the tool.
  const double s = 2 * std::numbers::pi * hz, s_free = 2 * std::numbers::pi * 20;
  bool good = solver.factor(dynamic_stiffness(body, s)) && (s > 0 || answers(body, solver));
  if (!good && s == 0) good = solver.factor(SparseMatrix(s_free * s_free * body.mass + body.stiffness));
  // A body that gives way to some motion does not at a higher rate; the basis need not be exact at this one.
  for (double higher : {5.0, 15.0, 45.0})
    if (!good && higher > hz) good = solver.factor(dynamic_stiffness(body, 2 * std::numbers::pi * higher));
  if (!good) throw IndefiniteTangent("reducer: the body's stiffness is not positive definite");
}

}  // namespace

MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                  SparseSolver& solver, int echoes, bool slopes) {
  std::vector<MatrixX> parts(shifts.size());
  MatrixX smooth = MatrixX::Zero(body.force.size(), kFarEach);
  smooth.topRows(body.dofs.size()) = smooth_loads(body.dofs, body.x, patch);
  MatrixX echo = MatrixX::Zero(body.force.size(), 3);
  std::vector<MatrixX> all_echoes;
  // Downwards: the factor that is left behind, at rest, serves for the certificate.
  for (std::size_t i = shifts.size(); i-- > 0;) {
    factor_at(body, shifts[i], solver);
    const bool outer = i == 0 || i + 1 == shifts.size();
    // The rim at the first shift only: a tool that runs onto it must find it no stiffer, but is about to leave.
    const MatrixX loads = outer ? body.inputs(patch, i == 0) : smooth;
    parts[i] = solver.solve(beside(loads, body.force));
    if (slopes) {
      const double s = 2 * std::numbers::pi * shifts[i];
      // What smooth loads move: a combination of what the nodes' loads do, which are columns of the identity.
      const MatrixX share = outer ? MatrixX(loads.transpose() * smooth) : MatrixX::Identity(kFarEach, kFarEach);
      const RowMatrix moved = parts[i].leftCols(loads.cols()) * share;
      RowMatrix slope = symmetric_times(body.mass, moved);
      if (s > 0) slope = 2 * s * slope + symmetric_times(body.damping, moved);
      parts[i] = beside(parts[i], solver.solve(slope));
    }
    if (i > 0) continue;
    for (Eigen::Index c = 0; c < loads.cols(); ++c) echo.col(c % 3) += parts[0].col(c);
    for (int e = 0; e < echoes; ++e) all_echoes.push_back(echo = solver.solve(symmetric_times(body.mass, echo)));
  }
  parts.push_back(body.velocity);
  parts.insert(parts.end(), all_echoes.begin(), all_echoes.end());
  Eigen::Index columns = 0;
  for (const MatrixX& part : parts) columns += part.cols();
  MatrixX out(body.force.size(), columns);
  columns = 0;
  for (const MatrixX& part : parts) {
    out.middleCols(columns, part.cols()) = part;
    columns += part.cols();
  }
  return out;
}

MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts) {
  return responses(body, patch, shifts, *make_sparse_solver(), 0, false);
}

namespace {

/// The columns of a positive semidefinite G that Cholesky's factorization takes, largest rest first, until the rest is
/// below `least`; and their factor L, in that order.
struct PivotedCholesky {
  std::vector<Eigen::Index> taken;
  MatrixX lower;
};

PivotedCholesky pivoted_cholesky(const MatrixX& gram, double least) {
  const Eigen::Index n = gram.rows();
  PivotedCholesky out{{}, MatrixX(n, n)};  // rows of `lower` in G's order until the end
  VectorX rest = gram.diagonal();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot;
    if (!(rest.maxCoeff(&pivot) > least)) break;
    VectorX column = gram.col(pivot);
    column.noalias() -= out.lower.leftCols(k) * out.lower.row(pivot).head(k).transpose();
    out.lower.col(k) = column / std::sqrt(column[pivot]);
    for (Eigen::Index i : out.taken) out.lower(i, k) = 0;
    rest -= out.lower.col(k).cwiseAbs2();
    out.taken.push_back(pivot);
    rest[pivot] = 0;
  }
  const auto rank = static_cast<Eigen::Index>(out.taken.size());
  out.lower = MatrixX(out.lower(out.taken, Eigen::all)).leftCols(rank).eval();
  return out;
}

}  // namespace

RowMatrix orthonormal_motions(const SparseMatrix& mass, const MatrixX& motions, double tolerance, int firm) {
  // A pass loses as many digits as directions that nearly coincide are kept apart by, twice over; a second one mends it
  // (Cholesky QR 2, Yamamoto et al. 2015, with pivots, which reveal the rank).
  RowMatrix V = motions;
  const double firmness = firm > 0 ? kFirmness : 1, least = 1e-14 * firmness * firmness;
  const int passes = tolerance / firmness < kOnePass ? 2 : 1;
  for (int pass = 0; pass < passes; ++pass) {
    RowMatrix inertia = symmetric_times(mass, V);
    const VectorX length = V.cwiseProduct(inertia).colwise().sum().cwiseSqrt();
    VectorX scale = (length.array() > 0).select(length.cwiseInverse(), 0.0);
    if (pass == 0) scale.tail(firm) *= kFirmness;
    const MatrixX gram = scale.asDiagonal() * symmetric_product(V, inertia) * scale.asDiagonal();
    const PivotedCholesky factor = pivoted_cholesky(gram, std::max(pass == 0 ? least : 1e-14, tolerance * tolerance));
    const auto rank = static_cast<Eigen::Index>(factor.taken.size());
    const MatrixX inverse = factor.lower.triangularView<Eigen::Lower>().solve(MatrixX::Identity(rank, rank));
    RowMatrix combine = RowMatrix::Zero(V.cols(), rank);
    combine(factor.taken, Eigen::all) = inverse.transpose();
    V = tall_product(V, scale.asDiagonal() * combine);
  }
  return V;
}

namespace {

MatrixX confined(const SparseMatrix& matrix, const RowMatrix& V) {
  return symmetric_product(V, symmetric_times(matrix, V));
}

}  // namespace

LocalModel confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch patch, const RowMatrix& V,
                   MatrixX* combination) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(confined(body.stiffness, V));
  const RowMatrix Q = eigen.eigenvectors();  // vibrations, in the coordinates of V
  const int r = static_cast<int>(V.cols()), p = patch.num_vertices();
  if (combination) *combination = Q;
  LocalModel out;
  out.definite_tangent = r > 0 && eigen.eigenvalues()[0] < -kRoundoff * eigen.eigenvalues()[r - 1];
  out.t = tangent.state.t;
  out.mass = SparseMatrix(VectorX::Ones(r).asDiagonal());
  // Motions that the body gives way to, a few of a compressed one, are left without a spring: that much stays passive.
  out.stiffness = SparseMatrix(VectorX(eigen.eigenvalues().cwiseMax(0)).asDiagonal());
  out.damping = sparse_of(symmetric_product(Q, tall_product(confined(body.damping, V), Q)));
  out.f0 = Q.transpose() * (V.transpose() * body.force);

  RowMatrix rows = RowMatrix::Zero(3 * p, r);
  const VectorX own_masses = body.mass.diagonal();
  VectorX own_springs = body.stiffness.diagonal();
  const double stiffest = own_springs.cwiseAbs().maxCoeff();  // a node that gives way by itself is hardly pulled at
  own_springs = own_springs.cwiseMax(stiffest > 0 ? kYield * stiffest : 1);
  VectorX node_spring = VectorX::Zero(3 * p), node_mass = node_spring;
  out.x0.resize(3 * p);
  out.v0.resize(3 * p);
  for (int i = 0; i < p; ++i) {
    const int g = patch.global_node[i];
    node(out.x0, i) = node(tangent.state.x, g);
    for (int c = 0; c < 3; ++c) {
      const int k = body.dofs.to_free[3 * g + c];
      out.v0[3 * i + c] = k < 0 ? 0 : tangent.state.v[3 * g + c];
      if (k < 0) continue;
      rows.row(3 * i + c) = V.row(k);
      node_spring[3 * i + c] = own_springs[k];
      node_mass[3 * i + c] = own_masses[k];
    }
  }
  const MatrixX basis = tall_product(rows, Q);
  out.basis = basis.sparseView(1, 0);
  // A body that is free to move follows too, and so do motions that are left without a spring.
  const double hardest = eigen.eigenvalues().cwiseAbs().maxCoeff();
  const VectorX springs = eigen.eigenvalues().cwiseMax(kSoftest * (hardest > 0 ? hardest : 1));
  Inverses of_springs = right_inverses(basis, springs, node_spring, patch.in_reach);
  Inverses of_masses = right_inverses(basis, VectorX::Ones(r), node_mass, patch.in_reach);
  out.lift = std::move(of_springs.exact);
  out.fit = std::move(of_springs.yielding);
  out.lift_rate = std::move(of_masses.exact);
  out.fit_rate = std::move(of_masses.yielding);
  out.q_rate0 = Q.transpose() * (V.transpose() * (body.mass * body.velocity));
  out.recovered_node = patch.global_node;
  out.patch = std::move(patch);
  return out;
}

}  // namespace kt
