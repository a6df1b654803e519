// The body seen from a contact against dense matrices of the whole one, and the products it is made with.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.hpp"
#include "core/linear/dense/orthonormalizer.hpp"
#include "core/linear/sparse_product.hpp"
#include "core/local/graded_body.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;

MatrixX dense_expansion(const GradedBody& graded, Eigen::Index coordinates) {
  MatrixX out(graded.all_dofs().size(), coordinates);
  for (Eigen::Index c = 0; c < coordinates; ++c)
    out.col(c) = graded.expand<1>(NodeRows<1>(VectorX::Unit(coordinates, c)));
  return out;
}

TEST(GradedBody, IsTheWholeOneConfinedToTheMotionsThatItExpandsTo) {
  for (const char* type : {"msd", "fem"}) {
    const LinearizedBlock b(6, type);
    const FreeBody whole(b.tangent);
    GradedBody graded;
    const FreeBody& body = graded.update(b.tangent, b.patch());
    ASSERT_FALSE(graded.is_whole());
    ASSERT_LT(body.force.size(), whole.force.size() * 3 / 4);
    const MatrixX E = dense_expansion(graded, body.force.size());
    EXPECT_LE(relative_error(body.mass, E.transpose() * (whole.mass * E)), kRoundoff);
    EXPECT_LE(relative_error(body.damping, E.transpose() * (whole.damping * E)), kRoundoff);
    EXPECT_LE(relative_error(body.stiffness, E.transpose() * (whole.stiffness * E)), kRoundoff);
    EXPECT_LE(relative_error(body.force, E.transpose() * whole.force), kRoundoff);
    EXPECT_LE(relative_error(graded.contract<1>(NodeRows<1>(whole.force)), body.force), kRoundoff);
    for (int i = 0; i < b.mesh.num_nodes(); ++i)
      for (int c = 0; c < 3; ++c)
        if (const int k = body.dofs.to_free[3 * i + c]; k >= 0) {
          EXPECT_EQ(VectorX(E.row(whole.dofs.to_free[3 * i + c])), VectorX(VectorX::Unit(E.cols(), k)));
          EXPECT_EQ(body.velocity[k], b.tangent.state.v[3 * i + c]);
        }
    for (int i : b.patch().global_node)
      EXPECT_TRUE(whole.dofs.to_free[3 * i] < 0 || body.dofs.to_free[3 * i] >= 0) << "every patch node is kept";
  }
}

/// The body with a spring between two nodes that were not coupled, as a contact of the body with itself adds.
TangentModel with_contact(TangentModel tangent, int a, int b, double k) {
  SparseMatrix contact(tangent.dfdx.rows(), tangent.dfdx.cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < 3; ++c)
    for (const auto& [i, j, sign] : {std::tuple{a, a, -1}, {b, b, -1}, {a, b, 1}, {b, a, 1}})
      for (int r = 0; r < 3; ++r) entries.emplace_back(3 * i + r, 3 * j + c, r == c ? sign * k : 0.0);
  contact.setFromTriplets(entries.begin(), entries.end());
  tangent.dfdx = SparseMatrix(tangent.dfdx + contact);
  return tangent;
}

TEST(GradedBody, FollowsContactsThatComeAndGo) {
  const LinearizedBlock b(6, "fem");
  const int n = b.mesh.num_nodes();
  GradedBody graded;
  graded.update(b.tangent, b.patch());
  ASSERT_FALSE(graded.is_whole());
  // The second pair has as many entries as the first.
  for (const auto& [i, k] : {std::pair{n - 1, n / 2}, {n - 3, n / 2 + 1}}) {
    const TangentModel tangent = with_contact(b.tangent, i, k, 1e3);
    const FreeBody whole(tangent);
    const FreeBody& body = graded.update(tangent, b.patch());
    const MatrixX E = dense_expansion(graded, body.force.size());
    EXPECT_LE(relative_error(body.stiffness, E.transpose() * (whole.stiffness * E)), kRoundoff) << i;
  }
}

TEST(GradedBody, FollowsAffineMotionsAboutTheFixedBase) {
  const LinearizedBlock b(8, "msd", 0);  // of 7, one far corner has its neighbours in a plane
  GradedBody graded;
  const FreeBody& body = graded.update(b.tangent, b.patch());
  ASSERT_FALSE(graded.is_whole());
  const Vec3 direction(0.3, -1, 0.7);
  NodeRows<1> coordinates = VectorX::Zero(body.force.size()), expected(graded.all_dofs().size());
  for (int k = 0; k < body.dofs.size(); ++k)
    coordinates[k] = b.mesh.x[body.dofs.to_all[k] / 3 * 3 + 2] * direction[body.dofs.to_all[k] % 3];
  for (int k = 0; k < expected.size(); ++k) {
    const int all = graded.all_dofs().to_all[k];
    expected[k] = b.mesh.x[all / 3 * 3 + 2] * direction[all % 3];
  }
  EXPECT_LE(relative_error(graded.expand<1>(coordinates), expected), kRoundoff);
}

TEST(GradedBody, VibratesAsSlowlyAsTheWholeOne) {
  const LinearizedBlock b(6, "fem");
  GradedBody graded;
  const FreeBody& body = graded.update(b.tangent, b.patch());
  ASSERT_FALSE(graded.is_whole());
  const FreeBody whole(b.tangent);
  const auto squared_rates = [](const FreeBody& f) { return generalized_eigenvalues(f.stiffness, f.mass); };
  const VectorX found = squared_rates(body), exact = squared_rates(whole);
  for (int k = 0; k < 8; ++k) {
    EXPECT_GE(found[k], exact[k] * (1 - 1e-9)) << "a confined body is stiffer, " << k;
    EXPECT_LE(found[k], exact[k] * 1.002) << k;
  }
}

TEST(FarMotions, SurviveABodyThatGivesWayAndComeBack) {
  const LinearizedBlock b(6, "fem", 0);
  TangentModel buckling = b.tangent;
  buckling.dfdx = -0.2 * b.tangent.dfdx;  // pushes itself away everywhere
  GradedBody graded;
  graded.update(b.tangent, b.patch());
  for (int k = 0; k < 20; ++k) graded.update(buckling, b.patch());
  for (int k = 0; k < 40; ++k) graded.update(b.tangent, b.patch());
  const FreeBody& body = graded.update(b.tangent, b.patch());
  const FreeBody whole(b.tangent);
  const auto slowest = [](const FreeBody& f) { return generalized_eigenvalues(f.stiffness, f.mass)[0]; };
  EXPECT_LE(slowest(body), 1.002 * slowest(whole));
  TangentModel broken = b.tangent;
  broken.dfdx.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
  graded.update(broken, b.patch());
  graded.update(broken, b.patch());
  for (int k = 0; k < 40; ++k) graded.update(b.tangent, b.patch());
  EXPECT_LE(slowest(graded.update(b.tangent, b.patch())), 1.002 * slowest(whole));
}

/// Static response of the patch, of the body against the whole one.
double static_error(const LinearizedBlock& b, const FreeBody& body) {
  const FreeBody whole(b.tangent);
  const MatrixX B = whole.inputs(b.patch()), Bc = body.inputs(b.patch());
  return relative_error(Bc.transpose() * solve_symmetric(body.stiffness, Bc),
                        B.transpose() * solve_symmetric(whole.stiffness, B));
}

TEST(GradedBody, YieldsAsTheWholeOneAndBetterAtEveryRefresh) {
  const LinearizedBlock b(7, "fem");
  GradedBody graded;
  const double first = static_error(b, graded.update(b.tangent, b.patch()));
  EXPECT_LE(first, 0.004);
  for (int refresh = 0; refresh < 10; ++refresh) graded.update(b.tangent, b.patch());
  const double later = static_error(b, graded.update(b.tangent, b.patch()));
  EXPECT_LT(later, first);
  GradedBody coarse({.slope = 1, .coarsest = 10});
  EXPECT_GT(static_error(b, coarse.update(b.tangent, b.patch())), later);
  EXPECT_LE(static_error(b, coarse.update_whole(b.tangent)), kRoundoff * 100);
}

TEST(GradedBody, KeepsItsNodesWhileThePatchStaysNear) {
  const LinearizedBlock b(7);
  SurfacePatch patch = b.patch(), far = patch;
  GradedBody graded;
  graded.update(b.tangent, patch);
  TangentModel moved = b.tangent;
  moved.state.x += 1e-3 * b.edge * random_vector(moved.state.x.size(), 5);
  graded.update(moved, patch);
  EXPECT_EQ(graded.gradings(), 1);
  for (int& i : far.global_node) i = b.mesh.num_nodes() - 1 - i;  // across the block
  const FreeBody& body = graded.update(b.tangent, far);
  EXPECT_EQ(graded.gradings(), 2);
  for (int i : far.global_node) EXPECT_TRUE(graded.all_dofs().to_free[3 * i] < 0 || body.dofs.to_free[3 * i] >= 0);
}

/// A patch that goes on by one node each time: nodes that were chosen around it last for two of these steps, those that
/// were chosen ahead of it, too, for four.
TEST(GradedBody, ChoosesItsNodesAheadOfAPatchThatGoesOn) {
  const LinearizedBlock b(10, "msd", 0);
  GradedBody graded({.margin = 2.1});
  std::vector<int> gradings;
  for (int step = -3; step <= 3; ++step) {
    SurfacePatch patch = b.patch();
    for (int& i : patch.global_node) i += step;
    const FreeBody& body = graded.update(b.tangent, patch);
    ASSERT_FALSE(graded.is_whole());
    for (int i : patch.global_node) EXPECT_GE(body.dofs.to_free[3 * i], 0) << step;
    gradings.push_back(graded.gradings());
  }
  EXPECT_EQ(gradings, (std::vector{1, 1, 2, 2, 2, 2, 3}));
}

TEST(NodesAhead, AreAddedToThoseOfThePatch) {
  const Mesh mesh = kuhn_block(8, 8, 2, 1.0);
  const auto number = [](int i, int j) { return i + 9 * (j + 9 * 2); };  // on the top
  const auto between = [&](int i0, int i1, int j0, int j1) {
    std::vector<int> out;
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) out.push_back(number(i, j));
    return out;
  };
  const std::vector<int> patch = between(3, 5, 3, 5);
  EXPECT_EQ(with_nodes_ahead(mesh.x, patch, Vec3(1.8, 0, 0)), between(3, 7, 3, 5));
  EXPECT_EQ(with_nodes_ahead(mesh.x, patch, Vec3(0, -1.1, 0)), between(3, 5, 2, 5));
  EXPECT_EQ(with_nodes_ahead(mesh.x, patch, Vec3::Zero()), patch);
  EXPECT_EQ(with_nodes_ahead(mesh.x, patch, Vec3(0.3, 0.2, 0)), patch);
  // At the body's end there is nothing ahead of the foremost nodes but themselves.
  EXPECT_EQ(with_nodes_ahead(mesh.x, between(7, 8, 3, 5), Vec3(3, 0, 0)), between(7, 8, 3, 5));
}

TEST(GradedBody, GivesTheSameBitsTwice) {
  const LinearizedBlock b(6, "fem");
  GradedBody one, two;
  for (int refresh = 0; refresh < 3; ++refresh) {
    const FreeBody &first = one.update(b.tangent, b.patch()), &second = two.update(b.tangent, b.patch());
    EXPECT_EQ(MatrixX(first.stiffness), MatrixX(second.stiffness));
    EXPECT_EQ(MatrixX(first.damping), MatrixX(second.damping));
  }
}

/// With the factor that leads its far motions.
TEST(GradedBody, ACopyGoesOnToTheSameBitsByItself) {
  const LinearizedBlock b(6, "fem");
  const auto reduce = [&](GradedBody& graded) {
    return MatrixX(find_reducer("krylov")(b.tangent, b.patch(), b.site, {.graded = &graded}).stiffness);
  };
  GradedBody one;
  const MatrixX start = reduce(one);
  const GradedBody kept = one;
  std::vector<MatrixX> went_on;
  for (int refresh = 0; refresh < 3; ++refresh) went_on.push_back(reduce(one));
  EXPECT_NE(went_on[2], start) << "it would not tell";
  for (int copy = 0; copy < 2; ++copy) {
    GradedBody two = kept;
    for (const MatrixX& expected : went_on) EXPECT_EQ(reduce(two), expected);
  }
}

TEST(Krylov, OfAGradedBodyStartsThePatchWhereItIs) {
  const LinearizedBlock b(6);
  GradedBody graded;
  const LocalModel m = find_reducer("krylov")(b.tangent, b.patch(), b.site, {.graded = &graded});
  ASSERT_FALSE(graded.is_whole());
  EXPECT_LE(relative_error(m.basis * m.q_rate0, m.v0), 1e-9);
  std::vector<int> rows;
  for (int i = 0; i < 3 * m.patch.num_vertices(); ++i)
    if (m.patch.in_reach[static_cast<std::size_t>(i / 3)]) rows.push_back(i);
  const MatrixX lifted = m.basis * m.lift;
  EXPECT_LE((lifted(rows, rows) - MatrixX::Identity(lifted.rows(), lifted.rows())(rows, rows)).norm(), 1e-9);
}

/// By a flag, with the springs clamped, or by an exception where no basis could be found.
TEST(Krylov, SaysWhenTheExactTangentIsIndefinite) {
  LinearizedBlock b(6);
  State pressed = b.tangent.state;
  for (int i = 0; i < b.mesh.num_nodes(); ++i) pressed.x[3 * i + 2] *= 0.5;
  for (double grading : {0.0, 0.45}) {
    const auto reduce = [&](TangentKind kind) {
      return find_reducer("krylov")(linearize(*b.model, pressed, kind), b.patch(), b.site, {.grading = grading});
    };
    try {
      const LocalModel clamped = reduce(TangentKind::exact);
      EXPECT_TRUE(clamped.definite_tangent);
      EXPECT_GE(MatrixX(clamped.stiffness).diagonal().minCoeff(), 0);
    } catch (const IndefiniteTangent&) {
    }
    EXPECT_FALSE(reduce(TangentKind::definite).definite_tangent);
    EXPECT_GT(MatrixX(reduce(TangentKind::definite).stiffness).diagonal().minCoeff(), 0);
  }
}

/// The mixed motions in long double: each stands apart from the others with length 1, or was dropped.
template <int N>
double worst_mix(const Eigen::Matrix<double, N, N>& motions) {
  const Eigen::Matrix<double, N, N> T = orthonormalizer<N>(motions.transpose() * motions);
  const auto mixed = (motions.template cast<long double>() * T.template cast<long double>()).eval();
  Eigen::Matrix<long double, N, N> off = mixed.transpose() * mixed;
  for (int c = 0; c < N; ++c) off(c, c) -= T.col(c).isZero(0) ? 0 : 1;
  return static_cast<double>(off.cwiseAbs().maxCoeff());
}

TEST(Orthonormalizer, KeepsItsDigitsOrDropsTheMotion) {
  constexpr double kDigits = 1e-4;  // rounding over what may cancel: 2e-16 / 1e-10, times entries
  using Square = Eigen::Matrix<double, 4, 4>;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  int dropped = 0;
  for (int problem = 0; problem < 1000; ++problem) {
    // Each motion is the last one, or what was new in it, but for a small part: weights grow from one to the next.
    const double part = std::pow(10, -7 * std::generate_canonical<double, 53>(random));
    Square motions = Square::NullaryExpr([&] { return normal(random); });
    motions.col(1) = motions.col(0) + part * motions.col(1);
    motions.col(2) = (motions.col(1) - motions.col(0)) / part + part * motions.col(2);
    EXPECT_LE(worst_mix<4>(motions), kDigits) << "part " << part;
    dropped += orthonormalizer<4>(motions.transpose() * motions).col(2).isZero(0);
  }
  EXPECT_GT(dropped, 100);
  EXPECT_LT(dropped, 900);
}

TEST(NodeRanks, SeparateNodesAndLeaveNoneAlone) {
  const VectorX x = 0.1 * random_vector(900, 4);
  const std::vector<double> ranks = node_ranks(x);
  for (double h : {0.01, 0.02, 0.05, 0.1})
    for (int i = 0; i < 300; ++i) {
      double nearest = 1;
      for (int k = 0; k < 300; ++k)
        if (k != i && ranks[k] >= h) nearest = std::min(nearest, (node(x, i) - node(x, k)).norm());
      if (ranks[i] >= h)
        EXPECT_GE(nearest, h * (1 - 1e-9));
      else
        EXPECT_LE(nearest, 1.2 * h);
    }
}

TEST(NodeBlocks, MultiplyAsTheSymmetricPartsOfTheMatricesDo) {
  Mesh mesh = kuhn_block(3, 2, 2, 0.01);
  const auto model = make_model(
      "fem", mesh, {.damping_mass = 1, .damping_stiffness = 1e-3, .fixed_nodes = {0, 5, 6}, .consistent_mass = true});
  State state = rest_state(*model);
  state.x += 1e-3 * random_vector(state.x.size(), 1);
  state.v = 0.1 * random_vector(state.x.size(), 2);
  const TangentModel tangent = linearize(*model, state);
  ASSERT_GT(relative_error(tangent.dfdx, MatrixX(tangent.dfdx.transpose())), 1e-6) << "moving, so not symmetric";
  const FreeBody whole(tangent);
  NodeBlocks blocks;
  blocks.update(tangent, whole.dofs);
  const NodeRows<6> u = random_vector(6 * whole.dofs.size(), 3).reshaped(whole.dofs.size(), 6);
  NodeRows<6> out, damped;
  blocks.stiffness_and_damping<6>(u, out, damped);
  EXPECT_LE(relative_error(out, whole.stiffness * MatrixX(u)), kRoundoff);
  EXPECT_LE(relative_error(damped, whole.damping * MatrixX(u)), kRoundoff);
  blocks.mass<6>(u, out);
  EXPECT_LE(relative_error(out, whole.mass * MatrixX(u)), kRoundoff);
  NodeRows<12> twice(u.rows(), 12), forces;
  twice << u, 2 * u;
  blocks.stiffness<12>(twice, forces);
  EXPECT_LE(relative_error(forces, whole.stiffness * MatrixX(twice)), kRoundoff);

  TangentModel odd = tangent;  // not in whole blocks
  odd.dfdx.coeffRef(30, 30) = 0;
  odd.dfdx.prune(1.0, 1e-300);
  blocks.update(odd, whole.dofs);
  blocks.stiffness<12>(twice, forces);
  EXPECT_LE(relative_error(forces, FreeBody(odd).stiffness * MatrixX(twice)), kRoundoff);
}

TEST(TallProducts, AgreeWithEigensForEverySize) {
  for (int n : {1, 3, 40, 133})
    for (int k : {1, 4, 16, 24, 30, 35}) {
      const RowMatrix A = random_vector(n * k, 1).reshaped(n, k), B = random_vector(k * 5, 2).reshaped(k, 5);
      const MatrixX S = random_positive_definite(n, 3);
      EXPECT_LE(relative_error(symmetric_product(A, RowMatrix(S * A)), A.transpose() * S * A), kRoundoff);
      EXPECT_LE(relative_error(tall_product(A, B), A * B), kRoundoff);
      EXPECT_LE(relative_error(symmetric_times(S.sparseView(), A), S * A), kRoundoff) << n << " " << k;
    }
}

}  // namespace
}  // namespace kt
