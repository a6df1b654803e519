// Reducers by projection and the impedance against dense matrices of the whole body.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "core/base/error.hpp"
#include "core/linear/dense/dense_solvers.hpp"
#include "core/local/far_motions.hpp"
#include "core/local/graded_body.hpp"
#include "core/local/impedance.hpp"
#include "core/local/local_dynamics.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

/// Displacement of the patch per force on it that grows as e^(s t), (3p x 3p), of the body and of the model.
MatrixX body_response(const LinearizedBlock& b, const SurfacePatch& patch, double s) {
  const FreeBody body(b.tangent);
  const MatrixX B = body.inputs(patch);
  return B.transpose() * solve_symmetric(s * s * body.mass + s * body.damping + body.stiffness, B);
}
/// Rows of the vertices in reach: those that the inputs push at.
MatrixX touchable_rows(const LocalModel& m) {
  std::vector<int> rows;
  for (int i = 0; i < 3 * m.patch.num_vertices(); ++i)
    if (m.patch.in_reach[static_cast<std::size_t>(i / 3)]) rows.push_back(i);
  return MatrixX(m.basis)(rows, Eigen::all);
}
MatrixX model_response(const LocalModel& m, double s) {
  const MatrixX B = touchable_rows(m);
  return B * solve_symmetric(s * s * m.mass + s * m.damping + m.stiffness, B.transpose());
}

TEST(Krylov, IsExactAtItsShifts) {
  const LinearizedBlock b(4);
  const LocalModel m = b.reduce("krylov", {.shifts_hz = {0, 60, 200}, .slopes = false, .rank_tolerance = 1e-6});
  // The patch's forces at two shifts, smooth ones at the third, the body's at all; the velocity; the echoes.
  EXPECT_LE(m.dof(), 2 * 3 * m.patch.num_vertices() + 12 + 3 + 1 + 3 * ReduceOptions().echoes);
  for (double hz : {0.0, 200.0}) {
    const double s = 2 * std::numbers::pi * hz;
    EXPECT_LE(relative_error(model_response(m, s), body_response(b, m.patch, s)), 1e-6) << hz;
  }
  const FreeBody body(b.tangent);
  const MatrixX loads = smooth_loads(body.dofs, body.x, m.patch);
  const double s = 2 * std::numbers::pi * 60;
  const MatrixX A = s * s * body.mass + s * body.damping + body.stiffness, basis = m.basis;
  MatrixX on_patch = MatrixX::Zero(basis.rows(), loads.cols());
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (const int k = body.dofs.to_free[3 * m.patch.global_node[static_cast<std::size_t>(i / 3)] + i % 3]; k >= 0)
      on_patch.row(i) = loads.row(k);
  const MatrixX A_model = s * s * m.mass + s * m.damping + m.stiffness;
  const MatrixX moved = basis * solve_symmetric(A_model, basis.transpose() * on_patch);
  const MatrixX moved_body = solve_symmetric(A, loads);
  MatrixX expected = on_patch;
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    if (const int k = body.dofs.to_free[3 * m.patch.global_node[static_cast<std::size_t>(i / 3)] + i % 3]; k >= 0)
      expected.row(i) = moved_body.row(k);
  EXPECT_LE(relative_error(moved, expected), 1e-6);
  EXPECT_LE(relative_error(model_response(m, 600), body_response(b, m.patch, 600)), 0.02);  // and close between
}

TEST(Krylov, FollowsSmoothLoadsToFirstOrderAroundItsShifts) {
  const LinearizedBlock b(4);
  const FreeBody body(b.tangent);
  SurfacePatch patch = b.patch();
  patch.in_reach.assign(patch.in_reach.size(), 1);  // so that the rim is pushed at both shifts too
  const MatrixX loads = smooth_loads(body.dofs, body.x, patch).topLeftCorner(body.dofs.size(), 12);
  // Work of the smooth loads in the motions that they cause: its error in s is of the order of the first that is not
  // matched, twice over (Galerkin).
  const auto error_at = [&](bool slopes, double hz) {
    const double s = 2 * std::numbers::pi * hz;
    const MatrixX V =
        orthonormal_motions(body.mass, responses(body, patch, {0, 200}, *make_sparse_solver(), 0, slopes), 1e-6);
    const MatrixX A = s * s * body.mass + s * body.damping + body.stiffness, f = V.transpose() * loads;
    const MatrixX exact = loads.transpose() * solve_symmetric(A, loads);
    return relative_error(f.transpose() * solve_symmetric(V.transpose() * A * V, f), exact);
  };
  for (const bool slopes : {false, true}) {
    const double order = std::log2(error_at(slopes, 240) / error_at(slopes, 220));
    EXPECT_NEAR(order, slopes ? 4 : 2, 0.5);
  }
  EXPECT_LT(error_at(true, 220), 0.05 * error_at(false, 220));
}

TEST(Krylov, StandsStillWhereAllIsClampedAndAtRest) {
  LinearizedBlock b(6, "fem", 0);
  b.tangent.f0.setZero();
  b.tangent.state.v.setZero();
  double lowest = 1;
  for (int t = 0; t < static_cast<int>(b.surface.triangles.size()); ++t) {
    Vec3 centroid = Vec3::Zero();
    for (int i : b.surface.triangles[t]) centroid += node(b.mesh.x, i) / 3;
    if (const double d = (centroid - Vec3(0.03, 0.03, 0)).norm(); d < lowest) {
      lowest = d;
      b.site = {centroid, t, 1e-3};
    }
  }
  const LocalModel m = b.reduce("krylov");
  EXPECT_GE(m.dof(), 1);
  EXPECT_EQ(m.basis.nonZeros(), 0) << "no node of the patch can move";
  EXPECT_GT(m.stiffness.coeff(0, 0), 0);
}

TEST(Condensed, IsGuyansReduction) {
  const LinearizedBlock b(4);
  const LocalModel m = b.reduce("condensed");
  EXPECT_LE(relative_error(model_response(m, 0), body_response(b, m.patch, 0)), 1e-9);
  // Away from rest: the static motions under unit displacements of the patch carry the mass.
  const FreeBody body(b.tangent);
  // Each node in reach is pushed by itself, the rim smoothly.
  const MatrixX touched = body.inputs(m.patch);
  const MatrixX smooth = smooth_loads(body.dofs, body.x, m.patch);
  const MatrixX on_rim = smooth - touched * (touched.transpose() * smooth);
  ASSERT_GT(on_rim.norm(), 0);
  MatrixX B(touched.rows(), touched.cols() + on_rim.cols());
  B << touched, on_rim;
  const MatrixX K = body.stiffness, C = solve_symmetric(K, B);
  MatrixX V(C.rows(), C.cols() + 2);
  V << C * (B.transpose() * C).inverse(), solve_symmetric(K, body.force), body.velocity;
  const double s = 300;
  const MatrixX A = s * s * MatrixX(body.mass) + s * MatrixX(body.damping) + K;
  const MatrixX expected = touched.transpose() * V * solve_symmetric(V.transpose() * A * V, V.transpose() * touched);
  EXPECT_LE(relative_error(model_response(m, s), expected), 1e-7);
}

/// The body's matrices confined to raw motions, known from what was solved, against products with the matrices.
void expect_confined(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                     const char* what) {
  constexpr double kSolved = 1e-9;  // a factor leaves as much of a load
  const ConfinedMotions found = confined_responses(body, patch, shifts, *make_sparse_solver(), 4, true);
  EXPECT_EQ(found.X, responses(body, patch, shifts, *make_sparse_solver(), 4, true)) << what;
  const auto expect = [&](const MatrixX& matrix, const SparseMatrix& of_body, const char* name) {
    const MatrixX expected = found.X.transpose() * (of_body * MatrixX(found.X));
    const VectorX scale = expected.diagonal().cwiseAbs().cwiseSqrt();
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
      for (Eigen::Index r = 0; r < matrix.rows(); ++r)
        EXPECT_NEAR(matrix(r, c), expected(r, c), kSolved * scale[r] * scale[c] + 1e-300) << what << name << r << c;
  };
  expect(found.mass, body.mass, " mass ");
  expect(found.damping, body.damping, " damping ");
  expect(found.stiffness, body.stiffness, " stiffness ");
}

/// Two tools squeeze a bar that bends under either of them a hundred times as far: by the mass of their motions, what
/// is left of two that bend alike is next to nothing.
TEST(Condensed, IsSqueezedByTwoToolsAsTheBodyIs) {
  const Mesh mesh = kuhn_block(14, 6, 3, 0.005);
  std::vector<int> clamped;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i] < 1e-6) clamped.push_back(i);
  const auto model = make_model("fem", mesh, {.young = 2e5, .poisson = 0.4, .fixed_nodes = clamped});
  const TangentModel tangent = linearize(*model, rest_state(*model), TangentKind::definite);
  const Surface surface = make_surface(mesh);
  ContactSite site = site_near(surface, mesh.x, {0.05, 0.015, 0.015}, 0.004);
  site.others = {site_near(surface, mesh.x, {0.05, 0.015, 0}, 0.004)};
  const LocalModel m = find_reducer("condensed")(tangent, make_patch(surface, mesh.x, site), site, {});
  const auto vertex_at = [&](const Vec3& at) {
    int best = 0;
    for (int v = 0; v < m.patch.num_vertices(); ++v)
      if ((node(m.x0, v) - at).norm() < (node(m.x0, best) - at).norm()) best = v;
    return best;
  };
  const int above = vertex_at(site.centre), below = vertex_at(site.others[0].centre);
  const FreeBody body(tangent);
  VectorX load = VectorX::Zero(body.force.size());
  load[body.dofs.to_free[3 * m.patch.global_node[above] + 2]] = -1;
  load[body.dofs.to_free[3 * m.patch.global_node[below] + 2]] = 1;
  const double squeezed = load.dot(VectorX(solve_symmetric(MatrixX(body.stiffness), MatrixX(load))));
  const VectorX of_model = MatrixX(m.basis).row(3 * below + 2) - MatrixX(m.basis).row(3 * above + 2);
  const double squeezed_model = of_model.dot(VectorX(solve_symmetric(MatrixX(m.stiffness), MatrixX(of_model))));
  EXPECT_NEAR(squeezed_model, squeezed, 1e-3 * squeezed);
}

TEST(Confined, StiffnessOfRawMotionsIsKnownFromWhatWasSolved) {
  for (const char* type : {"msd", "fem"}) {
    const LinearizedBlock b(3, type);
    const FreeBody body(b.tangent);
    expect_confined(body, b.patch(), {0, 200}, type);
    expect_confined(body, b.patch(), {0, 60, 200}, type);
    expect_confined(body, b.patch(), {0}, type);
    GradedBody graded;
    const LinearizedBlock large(6, type);
    expect_confined(graded.update(large.tangent, large.patch()), large.patch(), {0, 200}, "graded");
  }
  // Free to move: the first shift is another one; barely unstable: that of 15 Hz is.
  LinearizedBlock floating(3);
  floating.tangent.fixed_nodes.clear();
  expect_confined(FreeBody(floating.tangent), floating.patch(), {0, 200}, "floating");
  const LinearizedBlock b(3);
  FreeBody soft(b.tangent);
  const VectorX values = generalized_eigenvalues(MatrixX(soft.stiffness), MatrixX(soft.mass));
  const double lift = values[0] + std::pow(2 * std::numbers::pi * 10, 2);
  soft.stiffness -= lift * soft.mass;
  expect_confined(soft, b.patch(), {0, 200}, "soft");
  // Not in whole node blocks.
  FreeBody touching(b.tangent);
  touching.stiffness.coeffRef(0, touching.stiffness.cols() - 1) = -1e-3;
  touching.stiffness.coeffRef(touching.stiffness.rows() - 1, 0) = -1e-3;
  touching.stiffness.makeCompressed();
  expect_confined(touching, b.patch(), {0, 200}, "touching");
}

TEST(Confined, ModelOfRawMotionsIsThatOfOrthonormalOnes) {
  for (const char* type : {"msd", "fem"}) {
    const LinearizedBlock b(4, type);
    const FreeBody body(b.tangent);
    SurfacePatch patch = b.patch();
    constexpr double kTolerance = 3e-3;
    const ConfinedMotions motions = confined_responses(body, patch, {0, 200}, *make_sparse_solver(), 4, true);
    const LocalModel expected =
        confine(b.tangent, body, patch, orthonormal_motions(body.mass, motions.X, kTolerance, 12));
    MatrixX combination;
    const auto found = confine(b.tangent, body, patch, motions, kTolerance, 12, combination);
    ASSERT_TRUE(found);
    ASSERT_EQ(found->dof(), expected.dof());
    // Rounding of a pass is up to the inverse square of the tolerance with firm motions, 3e-5.
    for (double s : {0.0, 60.0, 600.0})
      EXPECT_LE(relative_error(model_response(*found, s), model_response(expected, s)), 1e-7) << type << s;
    const VectorX k = found->stiffness.diagonal(), k_expected = expected.stiffness.diagonal();
    EXPECT_LE((k - k_expected).cwiseQuotient(k_expected).cwiseAbs().maxCoeff(), 1e-6) << type;
    EXPECT_LE(relative_error(found->basis * found->q_rate0, expected.basis * expected.q_rate0), 1e-7) << type;
    EXPECT_LE(relative_error(found->basis * found->lift, expected.basis * expected.lift), 1e-7) << type;
    const MatrixX V = motions.X * combination;
    EXPECT_LE(relative_error(V.transpose() * (body.mass * V), MatrixX::Identity(V.cols(), V.cols())), 1e-6) << type;
    EXPECT_LE(relative_error(V.transpose() * (body.stiffness * V), MatrixX(found->stiffness)), 1e-6) << type;
  }
}

TEST(Subspace, DropsMotionsThatRepeatOthers) {
  const LinearizedBlock b(2);
  const FreeBody body(b.tangent);
  MatrixX motions(body.dofs.size(), 7);
  for (int c = 0; c < 4; ++c) motions.col(c) = random_vector(body.dofs.size(), static_cast<unsigned>(c));
  motions.col(4) = motions.col(0) + 1e-9 * random_vector(body.dofs.size(), 9);
  motions.col(5).setZero();
  motions.col(6) = 1e-12 * motions.col(1) - 3e-12 * motions.col(2);
  const MatrixX V = orthonormal_motions(body.mass, motions, 1e-6);
  ASSERT_EQ(V.cols(), 4);
  EXPECT_LE((V.transpose() * (body.mass * V) - MatrixX::Identity(4, 4)).norm(), 1e-12);
  for (int c = 0; c < 4; ++c)
    EXPECT_LE((V * (V.transpose() * (body.mass * motions.col(c))) - motions.col(c)).norm(),
              1e-8 * motions.col(c).norm());
}

TEST(Subspace, LeavesMotionsWithoutASpringThatTheBodyGivesWayTo) {
  const LinearizedBlock b(2);
  FreeBody body(b.tangent);
  const MatrixX V = orthonormal_motions(body.mass, body.inputs(b.patch()), 1e-6);
  EXPECT_GT(MatrixX(confine(b.tangent, body, b.patch(), V).stiffness).diagonal().minCoeff(), 0);
  body.stiffness -= 2 * body.stiffness;
  const LocalModel clamped = confine(b.tangent, body, b.patch(), V);
  EXPECT_TRUE(clamped.definite_tangent);
  EXPECT_EQ(MatrixX(clamped.stiffness).diagonal().norm(), 0);
}

/// A basis with hardly more motions than the patch has nodes follows any motion of these, but wildly: carried on at
/// every refresh, that throws a body apart.
TEST(Confine, TakesOverMotionsThatItsBasisHardlyFollowsWithLittleEnergy) {
  const LinearizedBlock b(3);
  const FreeBody body(b.tangent);
  const SurfacePatch patch = b.patch();
  // The slowest vibrations, as many as the patch has freedoms.
  const EigenPairs all = generalized_eigen(body.stiffness, body.mass);
  const RowMatrix V = all.vectors.leftCols(body.inputs(patch, false).cols());
  const LocalModel m = confine(b.tangent, body, patch, V);
  const MatrixX K = m.stiffness;
  VectorX motion = VectorX::Zero(m.basis.rows());
  double alone = 0;
  for (Eigen::Index i = 0; i < motion.size(); ++i) {
    const int k = body.dofs.to_free[3 * patch.global_node[static_cast<std::size_t>(i / 3)] + i % 3];
    if (!patch.in_reach[static_cast<std::size_t>(i / 3)] || k < 0) continue;
    motion[i] = i % 2 ? -1e-4 : 1e-4;
    alone += motion[i] * motion[i] * body.stiffness.coeff(k, k);
  }
  const auto energy = [&](const SparseMatrix& inverse) {
    const VectorX q = inverse * motion;
    return q.dot(K * q);
  };
  EXPECT_LE(energy(m.fit), 250 * alone);
  EXPECT_GT(energy(m.lift), 1000 * alone);  // the problem is one
}

/// A dent that gives way, as springs that buckle make it, is left without a spring: beside so soft a motion the others
/// must not drown in its rounding. It once threw a slab 1.6 m far.
TEST(Confine, TakesOverMotionsBesideOneWithoutASpring) {
  const LinearizedBlock b(4);
  FreeBody body(b.tangent);
  const SurfacePatch patch = b.patch();
  const MatrixX K = body.stiffness, M = body.mass;
  const MatrixX inputs = body.inputs(patch, false);
  const VectorX gives_way = inputs * random_vector(inputs.cols(), 99), pull = K * gives_way;
  const EigenPairs all = generalized_eigen(K, M);
  MatrixX motions = all.vectors.leftCols(inputs.cols() / 2);
  motions.col(0) = gives_way;
  const RowMatrix V = orthonormal_motions(body.mass, motions, 1e-6);
  body.stiffness = (K - 1.001 / gives_way.dot(pull) * pull * pull.transpose()).sparseView();
  const LocalModel m = confine(b.tangent, body, patch, V);
  ASSERT_TRUE(m.definite_tangent);
  // The same by least squares, without the normal equations.
  const MatrixX basis = m.basis;
  const VectorX weight = VectorX(m.stiffness.diagonal()).cwiseMax(1e-9 * m.stiffness.coeff(m.dof() - 1, m.dof() - 1));
  VectorX pulls = VectorX::Zero(basis.rows());
  for (Eigen::Index i = 0; i < pulls.size(); ++i) {
    const int k = body.dofs.to_free[3 * patch.global_node[static_cast<std::size_t>(i / 3)] + i % 3];
    if (!patch.in_reach[static_cast<std::size_t>(i / 3)] || k < 0) continue;
    pulls[i] = std::sqrt(1e3 * std::max(body.stiffness.coeff(k, k), 1e-3 * body.stiffness.diagonal().maxCoeff()));
  }
  MatrixX all_springs(m.dof() + basis.rows(), m.dof());
  all_springs << MatrixX(weight.cwiseSqrt().asDiagonal()), pulls.asDiagonal() * basis;
  MatrixX pulled(all_springs.rows(), basis.rows());
  pulled << MatrixX::Zero(m.dof(), basis.rows()), MatrixX(pulls.asDiagonal());
  const MatrixX expected = all_springs.colPivHouseholderQr().solve(pulled);
  EXPECT_LE((basis * (m.fit - expected)).norm(), 1e-8 * (basis * expected).norm());
}

TEST(Impedance, OfTheBodyAndOfItsModelsAgreesWithDenseMatrices) {
  const LinearizedBlock b(3);
  const FreeBody body(b.tangent);
  const LocalModel full = b.reduce("full");
  for (double hz : {0.0, 5.0, 50.0, 500.0}) {
    const double w = 2 * std::numbers::pi * hz;
    const Eigen::MatrixXcd dynamic = MatrixX(body.stiffness - w * w * body.mass).cast<std::complex<double>>() +
                                     std::complex<double>(0, w) * MatrixX(body.damping).cast<std::complex<double>>();
    const Eigen::MatrixXcd inverse = dynamic.inverse();
    const BodyCompliance of_body(body, hz);
    for (int vertex : {0, 3}) {
      const int node = full.patch.global_node[vertex];
      const std::vector<int> dofs{body.dofs.to_free[3 * node], body.dofs.to_free[3 * node + 1],
                                  body.dofs.to_free[3 * node + 2]};
      const ComplexMat3 exact = inverse(dofs, dofs);
      EXPECT_LE((of_body.at(node) - exact).norm(), 1e-6 * exact.norm()) << hz;
      EXPECT_LE((compliance(full, vertex, hz) - exact).norm(), 1e-9 * exact.norm()) << hz;
    }
  }
}

}  // namespace
}  // namespace kt
