// What every integrator of integrators.def and every reducer of reducers.def promises.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/global/integrator.hpp"
#include "core/local/local_dynamics.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;

std::string name_of(const testing::TestParamInfo<std::string>& test) { return test.param; }

std::vector<std::string> available(const std::vector<BackendInfo>& table) {
  std::vector<std::string> names;
  for (const BackendInfo& b : table)
    if (b.available) names.push_back(b.name);
  return names;
}

class EveryIntegrator : public testing::TestWithParam<std::string> {
 protected:
  const LinearizedBlock block_{2};
  State run(int steps, double dt) const {
    State s = block_.tangent.state;
    const auto stepper = make_integrator(GetParam());
    const VectorX push = 1e-4 * random_vector(s.x.size(), 3);
    for (int i = 0; i < steps; ++i) stepper->step(*block_.model, push, dt, s);
    return s;
  }
};

TEST_P(EveryIntegrator, LeavesFixedNodesWhereTheyAreAndCountsTime) {
  const State end = run(50, 1e-3);
  EXPECT_TRUE(end.x.allFinite() && end.v.allFinite());
  EXPECT_NEAR(end.t, 0.25 + 0.05, kRoundoff);
  for (int i : block_.model->fixed_nodes()) {
    EXPECT_EQ(Vec3(node(end.x, i)), Vec3(node(block_.mesh.x, i)));
    EXPECT_EQ(Vec3(node(end.v, i)), Vec3::Zero());
  }
}

TEST_P(EveryIntegrator, RepeatsItselfBitForBit) { EXPECT_EQ(run(20, 1e-3), run(20, 1e-3)); }

TEST_P(EveryIntegrator, KeepsABodyAtRestAtRest) {
  State s = rest_state(*block_.model);
  make_integrator(GetParam())->step(*block_.model, VectorX::Zero(s.x.size()), 1e-3, s);
  EXPECT_EQ(s.x, block_.mesh.x);
  EXPECT_EQ(s.v, VectorX::Zero(s.x.size()));
}

TEST_P(EveryIntegrator, IsStableAtItsOwnStableStep) {
  const auto stepper = make_integrator(GetParam());
  const double limit = stepper->stable_step(fastest_mode(*block_.model, rest_state(*block_.model)));
  State s = block_.tangent.state;
  s.x = block_.mesh.x + 1e-3 * (s.x - block_.mesh.x);
  s.v *= 1e-3;
  const double start = (s.x - block_.mesh.x).norm() + limit * s.v.norm();
  const double dt = std::min(0.1, 0.95 * limit);
  for (int i = 0; i < 1000; ++i) stepper->step(*block_.model, VectorX::Zero(s.x.size()), dt, s);
  EXPECT_LE((s.x - block_.mesh.x).norm(), start);
}

TEST_P(EveryIntegrator, DoesNothingToABodyThatIsFixedEverywhere) {
  const Mesh mesh = one_tetrahedron(0.01);
  const auto model = make_model("msd", mesh, {.fixed_nodes = {0, 1, 2, 3}});
  State s = rest_state(*model);
  const auto stepper = make_integrator(GetParam());
  EXPECT_TRUE(stepper->stable_step(fastest_mode(*model, s)) > 1e3);
  stepper->step(*model, VectorX::Ones(12), 1e-3, s);
  EXPECT_EQ(s.x, mesh.x);
}

INSTANTIATE_TEST_SUITE_P(Integrators, EveryIntegrator, testing::ValuesIn(available(integrator_backends())), name_of);

class EveryReducer : public testing::TestWithParam<std::string> {
 protected:
  const LinearizedBlock block_{3};
  const LocalModel model_ = block_.reduce(GetParam());
};

TEST_P(EveryReducer, GivesABasisWhoseFirstRowsAreThePatchAndWhatLiftsItsNodes) {
  const int p = model_.patch.num_vertices(), recovered = static_cast<int>(model_.recovered_node.size());
  ASSERT_GE(recovered, p);
  EXPECT_TRUE(
      std::equal(model_.patch.global_node.begin(), model_.patch.global_node.end(), model_.recovered_node.begin()));
  ASSERT_EQ(model_.basis.rows(), 3 * recovered);
  ASSERT_EQ(model_.basis.cols(), model_.dof());
  std::vector<int> in_reach;
  VectorX moves(3 * recovered);
  const std::vector<int>& fixed = block_.tangent.fixed_nodes;
  for (int i = 0; i < recovered; ++i) {
    node(moves, i).setConstant(std::binary_search(fixed.begin(), fixed.end(), model_.recovered_node[i]) ? 0 : 1);
    for (int c = 0; c < 3; ++c)
      if (i >= p || model_.patch.in_reach[i]) in_reach.push_back(3 * i + c);
  }
  EXPECT_GE(in_reach.size(), 9u);
  for (const SparseMatrix* lift : {&model_.lift, &model_.lift_rate}) {
    ASSERT_EQ(lift->rows(), model_.dof());
    const MatrixX found = model_.basis * *lift, expected = moves.asDiagonal();
    EXPECT_LE((found(in_reach, in_reach) - expected(in_reach, in_reach)).norm(), 1e-9);
  }
}

/// Motions that some model's basis can and this one's hardly can follow: no more energy than 250 times that of moving
/// each node by itself, which is what yielding by a thousandth bounds: l / (l + e)^2 <= 1 / (4 e).
TEST_P(EveryReducer, TakesOverMotionsOfAnotherModelWithLittleEnergy) {
  const MatrixX stiffness = model_.stiffness, basis = model_.basis;
  const double softest = 1e-12 * stiffness.diagonal().maxCoeff();
  const MatrixX springs = stiffness + softest * MatrixX::Identity(model_.dof(), model_.dof());
  struct Case {
    const SparseMatrix& fit;
    MatrixX matrix;
    VectorX own;  // of the body
  };
  for (const auto& [fit, matrix, own] : {Case{model_.fit, springs, -block_.tangent.dfdx.diagonal()},
                                         Case{model_.fit_rate, MatrixX(model_.mass), block_.tangent.mass.diagonal()}}) {
    const MatrixX response = basis * matrix.llt().solve(basis.transpose());
    VectorX motion = random_vector(basis.rows(), 5);
    double alone = 0;
    for (Eigen::Index i = 0; i < motion.size(); ++i) {
      const bool touched =
          i / 3 >= model_.patch.num_vertices() || model_.patch.in_reach[static_cast<std::size_t>(i / 3)];
      if (!touched || response(i, i) <= 0) motion[i] = 0;
      alone += motion[i] * motion[i] * own[3 * model_.recovered_node[static_cast<std::size_t>(i / 3)] + i % 3];
    }
    const VectorX q = fit * motion;
    EXPECT_LE(q.dot(matrix * q), 250 * alone);
    // Motions that it can follow it does follow: the nodes' answer to a load on one of them.
    for (int vertex = 0; vertex < model_.patch.num_vertices(); ++vertex) {
      if (!model_.patch.in_reach[vertex] || response(3 * vertex, 3 * vertex) <= 0) continue;
      VectorX answer = response.col(3 * vertex);
      for (Eigen::Index i = 0; i < 3 * model_.patch.num_vertices(); ++i)
        if (!model_.patch.in_reach[static_cast<std::size_t>(i / 3)]) answer[i] = 0;
      const VectorX followed = basis * (fit * answer);
      double off = 0;
      for (Eigen::Index i = 0; i < answer.size(); ++i)
        if (answer[i] != 0) off = std::max(off, std::abs(followed[i] - answer[i]));
      EXPECT_LE(off, 2e-3 * answer.lpNorm<Eigen::Infinity>()) << vertex;
    }
  }
}

TEST_P(EveryReducer, GivesSymmetricMatricesAPositiveMassAndPassiveSprings) {
  for (const SparseMatrix* m : {&model_.mass, &model_.damping, &model_.stiffness}) {
    ASSERT_EQ(m->rows(), model_.dof());
    EXPECT_LE(relative_error(*m, MatrixX(m->transpose())), kRoundoff);
    EXPECT_TRUE(m->isCompressed());
  }
  EXPECT_EQ(Eigen::LLT<MatrixX>(MatrixX(model_.mass)).info(), Eigen::Success);
  const MatrixX shift = 1e-9 * MatrixX::Identity(model_.dof(), model_.dof());
  EXPECT_EQ(Eigen::LLT<MatrixX>(MatrixX(model_.stiffness) + shift).info(), Eigen::Success);
  EXPECT_EQ(Eigen::LLT<MatrixX>(MatrixX(model_.damping) + shift).info(), Eigen::Success);
}

TEST_P(EveryReducer, StartsThePatchWhereTheBodyIs) {
  const State& s = block_.tangent.state;
  EXPECT_EQ(model_.t, s.t);
  EXPECT_EQ(model_.reducer, GetParam());
  EXPECT_TRUE(model_.f0.allFinite());
  for (std::size_t i = 0; i < model_.recovered_node.size(); ++i)
    EXPECT_EQ(Vec3(node(model_.x0, static_cast<int>(i))), Vec3(node(s.x, model_.recovered_node[i])));
  for (int i = 0; i < model_.patch.num_vertices(); ++i)
    EXPECT_EQ(Vec3(node(model_.v0, i)), Vec3(node(s.v, model_.patch.global_node[i])));
  EXPECT_LE(relative_error(model_.basis * model_.q_rate0, model_.v0), 1e-9);
}

TEST_P(EveryReducer, GivesTheSameBitsTwice) {
  const LocalModel again = block_.reduce(GetParam());
  EXPECT_EQ(MatrixX(again.stiffness), MatrixX(model_.stiffness));
  EXPECT_EQ(MatrixX(again.damping), MatrixX(model_.damping));
  EXPECT_EQ(MatrixX(again.basis), MatrixX(model_.basis));
  EXPECT_EQ(again.f0, model_.f0);
}

TEST_P(EveryReducer, IsStiffWhereEveryPatchNodeIsFixed) {
  LinearizedBlock b(3);
  for (int t = 0; t < static_cast<int>(b.surface.triangles.size()); ++t) {
    const Triangle& g = b.surface.triangles[t];
    if (node(b.mesh.x, g[0]).z() + node(b.mesh.x, g[1]).z() + node(b.mesh.x, g[2]).z() == 0)
      b.site = {node(b.mesh.x, g[0]), t, 0};
  }
  for (int rings : {0, 1}) {
    const LocalModel m = b.reduce(GetParam(), {.rings = rings});
    const LocalDynamics dynamics(m, LocalScheme::implicit_euler, Metric::implicit, 1e-3);
    for (int i = 0; i < m.patch.num_vertices(); ++i) {
      const bool fixed = node(b.mesh.x, m.patch.global_node[i]).z() == 0;
      EXPECT_EQ(dynamics.inertia().C.middleRows<3>(3 * i).norm() == 0, fixed) << "only fixed nodes resist impulses";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Reducers, EveryReducer, testing::ValuesIn(available(reducer_backends())), name_of);

TEST(Tables, NameTheKnownBackendsForAnUnknownOne) {
  EXPECT_EQ(message([] { make_integrator("implicit-euler"); }),
            "unknown integrator \"implicit-euler\": did you mean \"implicit_euler\"? (known: symplectic_euler, "
            "implicit_euler, newton_euler, sdirk2, implicit_midpoint, quasistatic)");
  const std::string reducer = message([] { find_reducer("walls"); });
  EXPECT_EQ(reducer.rfind("unknown reducer \"walls\": did you mean \"wall\"? (known: ", 0), 0u) << reducer;
  for (const BackendInfo& b : reducer_backends()) EXPECT_NE(reducer.find(b.name), std::string::npos);
  EXPECT_EQ(message([] { make_integrator(""); }).rfind("unknown integrator \"\" (known: ", 0), 0u);
}

TEST(Tables, DescribeEveryBackendAndNameNoneTwice) {
  for (const auto& table : {integrator_backends(), reducer_backends(), model_backends()})
    for (std::size_t i = 0; i < table.size(); ++i) {
      EXPECT_FALSE(table[i].what.empty()) << table[i].name;
      EXPECT_TRUE(table[i].available || !table[i].option.empty()) << table[i].name;
      for (std::size_t k = 0; k < i; ++k) EXPECT_NE(table[i].name, table[k].name);
    }
}

}  // namespace
}  // namespace kt
