#include "tests/support/fine_press.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <map>

#include "core/linear/free_dofs.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr double kYoung = 1e4, kWide = 0.06, kRadius = 0.008;

Mesh shaken_block(const PressBlockOptions& o) {
  const int wide = static_cast<int>(std::lround(kWide / o.cell));
  const int high = std::max(1, static_cast<int>(std::lround(o.thickness / o.cell)));
  Mesh mesh = kuhn_block(wide, wide, high, o.cell);
  Sample sample{std::mt19937_64(5)};
  const Vec3 most = bounds(mesh).max;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 by = o.shaken * o.cell * sample.cube(), at = node(mesh.x, i);
    for (int c = 0; c < 3; ++c)
      if (at[c] > 1e-9 && at[c] < most[c] - 1e-9) mesh.x[3 * i + c] += by[c];
    mesh.x[3 * i + 2] *= o.thickness / most.z();
  }
  return mesh;
}

double truth_of(double poisson, double thickness, double depth) {
  thread_local std::map<std::array<double, 3>, double> known;
  const auto [found, is_new] = known.try_emplace({poisson, thickness, depth});
  if (is_new)
    found->second = press_axisymmetric({.young = kYoung,
                                        .poisson = poisson,
                                        .thickness = thickness,
                                        .width = kWide / std::sqrt(3.14159265358979323846),
                                        .radius = kRadius,
                                        .depth = depth,
                                        .cells = 16})
                        .force;
  return found->second;
}

/// Force of a sphere that is pressed without friction, each point straight down: none pulls, none is left inside.
/// Active set of Lawson and Hanson 1974. Points of cells that are coarser than they are share out a force in many ways,
/// of which the even one is taken; the sum is the same.
/// @param wanted  how far each point is inside at first [m]
double pressed(MatrixX C, const VectorX& wanted) {
  C.diagonal().array() += 1e-8 * C.trace() / static_cast<double>(C.rows());
  VectorX force = VectorX::Zero(wanted.size());
  std::vector<int> active;
  const auto solved = [&] {
    const MatrixX A = C(active, active);
    const VectorX b = wanted(active), f = A.ldlt().solve(b);
    VectorX out = VectorX::Zero(wanted.size());
    out(active) = f;
    return out;
  };
  for (int pass = 0; pass < 10 * wanted.size(); ++pass) {
    VectorX inside = wanted - C * force;
    for (const int i : active) inside[i] = 0;
    int deepest = 0;
    if (inside.maxCoeff(&deepest) <= 1e-9 * wanted.maxCoeff()) return force.sum();
    active.push_back(deepest);
    for (VectorX next = solved();; next = solved()) {
      // The share of the way to the next forces after which one would pull.
      const auto share_of = [&](int i) { return next[i] > 0 ? 1 : force[i] / (force[i] - next[i]); };
      double share = 1;
      for (const int i : active) share = std::min(share, share_of(i));
      VectorX moved = force + share * (next - force);
      std::vector<int> left;
      for (const int i : active) {
        if (share == 1 || share_of(i) > share)
          left.push_back(i);
        else
          moved[i] = 0;
      }
      active = left;
      force = moved;
      if (share == 1) break;
    }
  }
  throw RunError("press: no contact found");
}

/// How the vertices of the body's top move points on it: flat triangles, as tools touch them.
SparseMatrix top_weights(const Mesh& mesh, const FineZone& zone) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < zone.num_yielding; ++i) {
    const Vec3 place = zone.nodes[zone.yielding()[i]].of(mesh.x);
    for (const Triangle& t : mesh.triangles) {
      Mat3 corners;
      for (int c = 0; c < 3; ++c) corners.col(c) = node(mesh.x, t[c]);
      if ((corners.row(2).array() < place.z() - 1e-9).any()) continue;
      corners.row(2).setOnes();
      const Vec3 share = corners.inverse() * Vec3(place.x(), place.y(), 1);
      if (share.minCoeff() < -1e-9) continue;
      for (int c = 0; c < 3; ++c) entries.emplace_back(i, t[c], std::max(share[c], 0.0));
      break;
    }
  }
  SparseMatrix out(zone.num_yielding, mesh.num_nodes());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace

PressBlock::PressBlock(const PressBlockOptions& options) : options_(options) {
  Mesh mesh = shaken_block(options);
  ModelOptions made{.young = kYoung, .poisson = options.poisson, .material = "linear", .element = options.element};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (node(mesh.x, i).z() < 1e-9) made.fixed_nodes.push_back(i);
  model_ = make_model(options.model, std::move(mesh), made);
  body_ = make_fine_body(*model_, *told_by(*model_));
  dfdx_ = model_->tangent(rest_state(*model_), TangentKind::symmetric).dfdx;
  solver_ = make_sparse_solver();
  const FreeDofs dofs = make_free_dofs(model_->mesh().num_nodes(), model_->fixed_nodes());
  if (!solver_->factor(gather(dofs, SparseMatrix(-dfdx_)))) throw RunError("press block: the body gives way");
}

MatrixX PressBlock::compliance_along_z(const SparseMatrix& W) const {
  const FreeDofs dofs = make_free_dofs(model_->mesh().num_nodes(), model_->fixed_nodes());
  MatrixX loads = MatrixX::Zero(dofs.size(), W.rows());
  for (int j = 0; j < W.cols(); ++j)
    if (const int row = dofs.to_free[3 * j + 2]; row >= 0)
      for (SparseMatrix::InnerIterator it(W, j); it; ++it) loads(row, it.row()) = it.value();
  return loads.transpose() * solver_->solve(loads);
}

FineZoneOptions press_options(const PressBlock& block, const FinePress& press) {
  const PressBlockOptions& o = block.options();
  const double a = std::sqrt(kRadius * press.depth);
  const Vec3 centre(0.5 * kWide + press.x * o.cell, 0.5 * kWide + press.y * o.cell, o.thickness);
  FineZoneOptions out = fine_options(block.body(), {centre, a, press.travel}, press.fineness);
  out.radius = std::max(press.cells_around * o.cell, a + press.travel + 0.5 * o.cell);
  out.most_nodes = press.most_nodes;
  return out;
}

FinePressed press_fine(const PressBlock& block, const FinePress& press) {
  const PressBlockOptions& o = block.options();
  const FineZoneOptions wanted = press_options(block, press);
  const FineZone zone = make_fine_zone(block.body(), wanted);
  const auto solver = make_block_solver();
  const State rest = rest_state(block.model());
  const FineYield yield = find_yield(block.body(), zone, {rest}, block.dfdx(), *solver);

  const MatrixX C = block.compliance_along_z(coarse_weights(block.body(), zone, zone.yielding()));
  const auto along_z = Eigen::seqN(2, zone.num_yielding, 3);
  VectorX inside(zone.num_yielding);
  for (int i = 0; i < zone.num_yielding; ++i) {
    const Vec3 away = zone.nodes[zone.yielding()[i]].of(block.body().mesh->x) - wanted.centre;
    const double under = kRadius * kRadius - away.squaredNorm();
    inside[i] = under > 0 ? press.depth - (kRadius - std::sqrt(under)) : -kRadius;
  }
  const double truth = truth_of(o.poisson, o.thickness, press.depth);
  return {.coarse = pressed(block.compliance_along_z(top_weights(*block.body().mesh, zone)), inside) / truth,
          .fine = pressed(C + yield.R(along_z, along_z), inside) / truth,
          .truth = truth,
          .fineness = zone.edge / std::sqrt(kRadius * press.depth),
          .unknown = zone.num_unknown(),
          .yielding = zone.num_yielding,
          .inner = static_cast<int>(zone.inner.size()),
          .least = yield.least};
}

}  // namespace kt
