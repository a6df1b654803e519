#include "core/local/subspace.hpp"

#include <Eigen/Cholesky>
#include <numbers>

#include "core/base/error.hpp"
#include "core/base/wide.hpp"
#include "core/linear/dense/dense_cholesky.hpp"
#include "core/linear/dense/symmetric_eigen.hpp"
#include "core/linear/sparse_product.hpp"
#include "core/local/far_motions.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-10;     // of the largest spring: less is no instability
constexpr double kProportional = 1e-9;  // off the diagonal, of the damping between two vibrations
constexpr double kOnePass = 1e-5;       // [-] rank tolerance that one orthonormalization is good for
constexpr double kFirmness = 100;       // how much longer than the others firm motions count
constexpr double kSoftest = 1e-9;       // of the largest spring: what a motion without one is given to follow others
constexpr double kYield = 1e-3;         // [-] of what a node gives way alone, all else held

/// All entries but zeros, in one pass a column.
SparseMatrix compressed(const MatrixX& m) {
  SparseMatrix out(m.rows(), m.cols());
  out.resizeNonZeros((m.array() != 0).count());
  int count = 0;
  for (int c = 0; c < m.cols(); ++c) {
    out.outerIndexPtr()[c] = count;
    for (int r = 0; r < m.rows(); ++r)
      if (m(r, c) != 0) {
        out.innerIndexPtr()[count] = r;
        out.valuePtr()[count++] = m(r, c);
      }
  }
  out.outerIndexPtr()[m.cols()] = count;
  return out;
}

/// Diagonal where the rest is roundoff; else every entry, zeros too.
SparseMatrix sparse_of(const MatrixX& m) {
  const VectorX scale = m.diagonal().cwiseAbs().cwiseSqrt();
  bool diagonal = true;
  for (int c = 0; c < m.cols() && diagonal; ++c)
    for (int r = 0; r < m.rows(); ++r) diagonal &= r == c || std::abs(m(r, c)) <= kProportional * scale[r] * scale[c];
  if (diagonal) return SparseMatrix(VectorX(m.diagonal()).asDiagonal());
  SparseMatrix out(m.rows(), m.cols());
  out.resizeNonZeros(m.size());
  Eigen::Map<MatrixX>(out.valuePtr(), m.rows(), m.cols()) = 0.5 * (m + m.transpose());
  for (int c = 0; c <= m.cols(); ++c) out.outerIndexPtr()[c] = c * static_cast<int>(m.rows());
  for (int k = 0; k < m.size(); ++k) out.innerIndexPtr()[k] = k % static_cast<int>(m.rows());
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
  constexpr double kIndependent = 1e-10;  // pivot of R: below, it is looked for with pivots
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    if (in_reach[static_cast<std::size_t>(i / 3)] && !B.row(i).isZero(0)) rows.push_back(i);
  const RowMatrix moving_t = B(rows, Eigen::all).transpose();
  const RowMatrix eased = weight.cwiseInverse().asDiagonal() * moving_t;
  const MatrixX response = symmetric_product(moving_t, eased);
  MatrixX out = MatrixX::Zero(B.cols(), B.rows());
  Inverses both;
  if (const std::optional<RowMatrix> inverse = inverse_factor(response, kIndependent))
    out(Eigen::all, rows) = tall_product(tall_product(eased, inverse->transpose()), *inverse);
  else
    out(Eigen::all, rows) = MatrixX(response.ldlt().solve(MatrixX(eased.transpose()))).transpose();
  both.exact = compressed(out);
  const VectorX pull = own(rows) / kYield;
  const RowMatrix pulled_t = moving_t * pull.asDiagonal(), pulled = pulled_t.transpose();
  MatrixX resisted = symmetric_product(moving_t.transpose(), pulled);
  resisted.diagonal() += weight;
  if (const std::optional<RowMatrix> inverse = inverse_factor(resisted))
    out(Eigen::all, rows) = tall_product(inverse->transpose(), tall_product(*inverse, pulled_t));
  else
    out(Eigen::all, rows) = MatrixX(resisted.ldlt().solve(MatrixX(pulled_t)));
  both.yielding = compressed(out);
  return both;
}

/// The columns of a positive semidefinite G that Cholesky's factorization takes, largest rest first, until the rest is
/// below `least`; and their factor L, in that order.
struct PivotedCholesky {
  std::vector<Eigen::Index> taken;
  MatrixX lower;
};

/// column -= sum_k weight_k L_k, four columns of L at a time.
KT_WIDE void take_columns(double* __restrict column, const double* L, Eigen::Index stride, const double* weight,
                          Eigen::Index count, Eigen::Index n) {
  Eigen::Index k = 0;
  for (; k + 3 < count; k += 4) {
    const double *l0 = L + stride * k, *l1 = l0 + stride, *l2 = l1 + stride, *l3 = l2 + stride;
    for (Eigen::Index i = 0; i < n; ++i)
      column[i] -= weight[k] * l0[i] + weight[k + 1] * l1[i] + weight[k + 2] * l2[i] + weight[k + 3] * l3[i];
  }
  for (; k < count; ++k)
    for (Eigen::Index i = 0; i < n; ++i) column[i] -= weight[k] * L[stride * k + i];
}

PivotedCholesky pivoted_cholesky(const MatrixX& gram, double least) {
  const Eigen::Index n = gram.rows();
  PivotedCholesky out{{}, MatrixX(n, n)};  // rows of `lower` in G's order until the end
  VectorX rest = gram.diagonal();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot;
    if (!(rest.maxCoeff(&pivot) > least)) break;
    VectorX column = gram.col(pivot);
    const VectorX weight = out.lower.row(pivot).head(k);
    take_columns(column.data(), out.lower.data(), n, weight.data(), k, n);
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

/// Which motions are kept, and how these are mixed so that they are orthonormal in the mass: column by column.
struct Mix {
  std::vector<Eigen::Index> taken;
  RowMatrix weights;  // (taken x rank), upper triangular
};

/// @param gram  of the motions, in the mass
Mix orthonormal_mix(const MatrixX& gram, const VectorX& firmness, double least) {
  const VectorX length = gram.diagonal().cwiseMax(0).cwiseSqrt();
  VectorX scale = (length.array() > 0).select(length.cwiseInverse(), 0.0);
  scale.array() *= firmness.array();
  PivotedCholesky factor = pivoted_cholesky(scale.asDiagonal() * gram * scale.asDiagonal(), least);
  RowMatrix weights = VectorX(scale(factor.taken)).asDiagonal() * invert_lower(factor.lower).transpose();
  return {std::move(factor.taken), std::move(weights)};
}

VectorX firmness_of(Eigen::Index columns, int firm) {
  VectorX out = VectorX::Ones(columns);
  out.tail(firm) *= kFirmness;
  return out;
}

double least_rest(double tolerance, int firm) {
  const double firmness = firm > 0 ? kFirmness : 1;
  return std::max(1e-14 * firmness * firmness, tolerance * tolerance);
}

}  // namespace

bool is_one_pass(double tolerance, int firm) { return tolerance / (firm > 0 ? kFirmness : 1) >= kOnePass; }

RowMatrix orthonormal_motions(const SparseMatrix& mass, const MatrixX& motions, double tolerance, int firm) {
  // A pass loses as many digits as directions that nearly coincide are kept apart by, twice over; a second one mends it
  // (Cholesky QR 2, Yamamoto et al. 2015, with pivots, which reveal the rank).
  RowMatrix V = motions;
  const SymmetricMatrix inertia(mass);
  const int passes = is_one_pass(tolerance, firm) ? 1 : 2;
  for (int pass = 0; pass < passes; ++pass) {
    const MatrixX gram = symmetric_product(V, inertia.times(V));
    const Mix mix = pass == 0 ? orthonormal_mix(gram, firmness_of(V.cols(), firm), least_rest(tolerance, firm))
                              : orthonormal_mix(gram, VectorX::Ones(V.cols()), least_rest(tolerance, 0));
    V = tall_product(RowMatrix(V(Eigen::all, mix.taken)), mix.weights);
  }
  return V;
}

namespace {

MatrixX confined(const SparseMatrix& matrix, const RowMatrix& V) {
  return symmetric_product(V, symmetric_times(matrix, V));
}

/// The matrices of a local model in its vibrations, and how these move the patch.
struct Vibrations {
  SymmetricEigen eigen;  // of the stiffness
  MatrixX damping;
  VectorX force, velocity;
  RowMatrix patch_rows;  // of the motions, (3p x motions); zero: immovable
  RowMatrix in_motions;  // (motions x r)
};

/// Rows of the motions of the patch's nodes.
RowMatrix rows_of_patch(const FreeBody& body, const SurfacePatch& patch, const RowMatrix& motions) {
  RowMatrix out = RowMatrix::Zero(3 * patch.num_vertices(), motions.cols());
  for (int i = 0; i < patch.num_vertices(); ++i)
    for (int c = 0; c < 3; ++c)
      if (const int k = body.dofs.to_free[3 * patch.global_node[i] + c]; k >= 0) out.row(3 * i + c) = motions.row(k);
  return out;
}

LocalModel make_model(const TangentModel& tangent, const FreeBody& body, SurfacePatch patch, const Vibrations& of) {
  const int r = static_cast<int>(of.in_motions.cols()), p = patch.num_vertices();
  const VectorX& springs_found = of.eigen.values;
  LocalModel out;
  out.definite_tangent = r > 0 && springs_found[0] < -kRoundoff * springs_found[r - 1];
  out.t = tangent.state.t;
  out.mass = SparseMatrix(VectorX::Ones(r).asDiagonal());
  // Motions that the body gives way to, a few of a compressed one, are left without a spring: that much stays passive.
  out.stiffness = SparseMatrix(VectorX(springs_found.cwiseMax(0)).asDiagonal());
  out.damping = sparse_of(of.damping);
  out.f0 = of.force;
  out.q_rate0 = of.velocity;

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
      node_spring[3 * i + c] = own_springs[k];
      node_mass[3 * i + c] = own_masses[k];
    }
  }
  const MatrixX basis = tall_product(of.patch_rows, of.in_motions);
  out.basis = compressed(basis);
  // A body that is free to move follows too, and so do motions that are left without a spring.
  const double hardest = springs_found.cwiseAbs().maxCoeff();
  const VectorX springs = springs_found.cwiseMax(kSoftest * (hardest > 0 ? hardest : 1));
  Inverses of_springs = right_inverses(basis, springs, node_spring, patch.in_reach);
  Inverses of_masses = right_inverses(basis, VectorX::Ones(r), node_mass, patch.in_reach);
  out.lift = std::move(of_springs.exact);
  out.fit = std::move(of_springs.yielding);
  out.lift_rate = std::move(of_masses.exact);
  out.fit_rate = std::move(of_masses.yielding);
  out.recovered_node = patch.global_node;
  out.patch = std::move(patch);
  return out;
}

}  // namespace

LocalModel confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch patch, const RowMatrix& V,
                   MatrixX* combination) {
  Vibrations out;
  out.eigen = symmetric_eigen(confined(body.stiffness, V));
  out.in_motions = out.eigen.vectors;
  const RowMatrix& Q = out.in_motions;
  out.damping = symmetric_product(Q, tall_product(confined(body.damping, V), Q));
  out.force = Q.transpose() * (V.transpose() * body.force);
  out.velocity = Q.transpose() * (V.transpose() * (body.mass * body.velocity));
  out.patch_rows = rows_of_patch(body, patch, V);
  if (combination) *combination = Q;
  return make_model(tangent, body, std::move(patch), out);
}

std::optional<LocalModel> confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch& patch,
                                  const ConfinedMotions& motions, double tolerance, int firm, MatrixX& combination) {
  const Mix mix = orthonormal_mix(motions.mass, firmness_of(motions.X.cols(), firm), least_rest(tolerance, firm));
  if (mix.taken.empty()) return {};
  const auto taken = [&](const MatrixX& all) { return RowMatrix(all(mix.taken, mix.taken)); };
  const RowMatrix turned = mix.weights.transpose();
  Vibrations out;
  const RowMatrix confined_once = tall_product(turned, taken(motions.stiffness));
  out.eigen = symmetric_eigen(symmetric_product(confined_once.transpose(), mix.weights));
  out.in_motions = tall_product(mix.weights, out.eigen.vectors);
  out.damping = symmetric_product(out.in_motions, tall_product(taken(motions.damping), out.in_motions));
  const VectorX force = motions.X.transpose() * body.force;
  const VectorX velocity = motions.X.transpose() * (body.mass * body.velocity);
  out.force = out.in_motions.transpose() * force(mix.taken);
  out.velocity = out.in_motions.transpose() * velocity(mix.taken);
  out.patch_rows = rows_of_patch(body, patch, motions.X)(Eigen::all, mix.taken);
  combination = MatrixX::Zero(motions.X.cols(), out.in_motions.cols());
  combination(mix.taken, Eigen::all) = out.in_motions;
  return make_model(tangent, body, std::move(patch), out);
}

}  // namespace kt
