#include "core/fine/fine_yield.hpp"

#include <numeric>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/stages.hpp"
#include "core/linear/dense/dense_cholesky.hpp"
#include "core/linear/dense/symmetric_eigen.hpp"
#include "core/linear/trailing_inverse.hpp"

namespace kt {
namespace {

/// Symmetric part of the rows and columns of some nodes.
MatrixX block_of(const SparseMatrix& all, std::span<const int> nodes) {
  const auto n = static_cast<Eigen::Index>(nodes.size());
  std::vector<int> number(static_cast<std::size_t>(all.rows() / 3), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) number[nodes[i]] = static_cast<int>(i);
  MatrixX out = MatrixX::Zero(3 * n, 3 * n);
  for (const int i : nodes)
    for (int c = 0; c < 3; ++c)
      for (SparseMatrix::InnerIterator it(all, 3 * i + c); it; ++it)
        if (const int j = number[it.row() / 3]; j >= 0) out(3 * j + it.row() % 3, 3 * number[i] + c) = it.value();
  return 0.5 * (out + out.transpose());
}

[[noreturn]] void throw_indefinite(const char* which) {
  throw IndefiniteTangent(text("fine patch: the ", which, " stiffness around the contact is not positive definite"));
}

/// Three coordinates each.
SparseMatrix in_space(const SparseMatrix& weights) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < weights.outerSize(); ++j)
    for (SparseMatrix::InnerIterator it(weights, j); it; ++it)
      for (int d = 0; d < 3; ++d) entries.emplace_back(3 * static_cast<int>(it.row()) + d, 3 * j + d, it.value());
  SparseMatrix out(3 * weights.rows(), 3 * weights.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// How places of an embedded surface go with the yielding nodes.
SparseMatrix place_weights(const FineZone& zone) {
  const EmbeddedFacets& e = zone.embedded;
  const int begin = zone.num_unknown() - zone.num_yielding;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(e.places.size()); ++i) {
    const auto v = static_cast<std::size_t>(e.places[i]);
    for (std::size_t c = 0; c < 4; ++c)
      for (int k = zone.first[e.node[v][c]]; k < zone.first[e.node[v][c] + 1]; ++k)
        if (zone.from[k] >= begin) entries.emplace_back(i, zone.from[k] - begin, e.weight[v][c] * zone.weight[k]);
  }
  SparseMatrix out(static_cast<Eigen::Index>(e.places.size()), zone.num_yielding);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// S_f.
/// @param places  of the yielding nodes; null: these themselves
MatrixX fine_compliance(const FineZone& zone, const SparseMatrix& K, const SparseMatrix* places, SparseSolver& solver) {
  std::vector<int> last(static_cast<std::size_t>(zone.num_yielding));
  std::iota(last.begin(), last.end(), zone.num_unknown() - zone.num_yielding);
  solver.order_last(last);
  {
    const Stage stage("fine.factor");
    if (!solver.factor(K)) throw_indefinite("refined");
  }
  const Stage stage("fine.inverse");
  if (places) return trailing_inverse(solver, K.rows(), in_space(*places));
  return trailing_inverse(solver, K.rows(), 3 * zone.num_yielding);
}

/// W S_c W^T.
MatrixX coarse_compliance(const FineBody& body, const FineZone& zone, const SparseMatrix* places,
                          const SparseMatrix& dfdx) {
  const Stage stage("fine.coarse");
  SparseMatrix all = coarse_weights(body, zone, zone.yielding());
  if (places) all = SparseMatrix(*places * all);
  SparseMatrix inner(all.rows(), static_cast<Eigen::Index>(zone.inner.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t j = 0; j < zone.inner.size(); ++j)
    for (SparseMatrix::InnerIterator it(all, zone.inner[j]); it; ++it)
      entries.emplace_back(static_cast<int>(it.row()), static_cast<int>(j), it.value());
  inner.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix W = in_space(inner);
  const auto factor = inverse_factor(-block_of(dfdx, zone.inner));
  if (!factor) throw_indefinite("coarse");
  const MatrixX left = W * inverse_from(*factor);
  return left * W.transpose();
}

bool is_definite_with(double added, const MatrixX& R) {
  MatrixX shifted = R;
  shifted.diagonal().array() += added;
  return is_positive_definite(shifted);
}

/// Where R has negative eigenvalues but by rounding, and is not positive definite either with up to a twentieth of its
/// mean diagonal added to each node's own compliance, they are set to zero: that takes thirty times as long.
/// @param whole  the fine compliance, whose digits R has
void make_semidefinite(double whole, FineYield& yield) {
  const Stage stage("fine.definite");
  const double mean = yield.R.trace() / static_cast<double>(yield.R.rows());
  if (is_definite_with(1e-9 * mean + 1e-12 * whole / static_cast<double>(yield.R.rows()), yield.R)) return;
  for (const double share : {1e-3, 1e-2, 5e-2})
    if (is_definite_with(share * mean, yield.R)) {
      yield.added = share * mean;
      yield.R.diagonal().array() += yield.added;
      return;
    }
  const SymmetricEigen eigen = symmetric_eigen(yield.R);
  const Eigen::Index n = eigen.values.size();
  yield.least = eigen.values[0] / std::max(eigen.values[n - 1], -eigen.values[0]);
  yield.R = eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
  yield.R = MatrixX(0.5 * (yield.R + yield.R.transpose()));
}

}  // namespace

SparseMatrix coarse_weights(const FineBody& body, const FineZone& zone, std::span<const int> nodes) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    const CellPoint& p = zone.nodes[nodes[i]];
    for (int k = 0; k < p.count; ++k) {
      const double share = p.share(k);
      entries.emplace_back(i, p.corner[k], body.is_quadratic() ? share * (2 * share - 1) : share);
      for (int l = k + 1; l < p.count && body.is_quadratic(); ++l)
        entries.emplace_back(i, body.edge_node.at({p.corner[k], p.corner[l]}), 4 * share * p.share(l));
    }
  }
  SparseMatrix out(static_cast<Eigen::Index>(nodes.size()), body.mesh->num_nodes());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

FineYield find_yield(const FineBody& body, const FineZone& zone, const FineState& state, const SparseMatrix& dfdx,
                     SparseSolver& solver) {
  FineYield out;
  out.retardation = body.material->retardation();
  if (zone.num_yielding == 0) return out;
  SparseMatrix K;
  {
    const Stage stage("fine.matrices");
    K = fine_stiffness(body, zone, state);
  }
  std::optional<SparseMatrix> places;
  if (!zone.embedded.places.empty()) places = place_weights(zone);
  const SparseMatrix* const at = places ? &*places : nullptr;
  out.R = fine_compliance(zone, K, at, solver);
  const double whole = out.R.trace();
  if (!zone.inner.empty()) out.R -= coarse_compliance(body, zone, at, dfdx);
  out.R = MatrixX(0.5 * (out.R + out.R.transpose()));
  make_semidefinite(whole, out);
  return out;
}

}  // namespace kt
