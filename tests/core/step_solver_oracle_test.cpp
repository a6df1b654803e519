// The matrix of a step against Eigen's sums; its solvers against dense algebra and one another; Newton's method against
// closed forms.
#include "core/linear/step_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/global/newton.hpp"
#include "models/model.hpp"
#include "tests/support/linear_model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

struct Cantilever {
  explicit Cantilever(int cells, const std::string& material = "corotational") {
    const Mesh mesh = kuhn_block(cells, cells, 4 * cells, 0.1 / cells);
    model = make_model("fem", mesh,
                       {.young = 1e5,
                        .damping_mass = 1,
                        .damping_stiffness = 1e-3,
                        .fixed_nodes = nodes_below(mesh, 1e-9),
                        .material = material,
                        .gravity = Vec3(-9.81, 0, 0)});
  }
  FreeDofs dofs() const { return make_free_dofs(model->mesh().num_nodes(), model->fixed_nodes()); }
  State bent() const {
    State s = rest_state(*model);
    for (int i = 0; i < s.x.size(); i += 3) s.x[i] -= 0.5 * s.x[i + 2] * s.x[i + 2];
    return s;
  }
  std::unique_ptr<DeformableModel> model;
};

TEST(StepMatrix, IsTheSumOfItsTermsOnTheFreeNodes) {
  const Cantilever c(2);
  const Tangent t = c.model->tangent(c.bent(), TangentKind::exact);
  StepMatrix matrix(c.dofs());
  for (double dt : {0.01, 0.3}) {  // the second sum uses the pattern of the first
    const MatrixX sum = matrix.sum({{{1, &c.model->mass()}, {-dt, &t.dfdv}, {-dt * dt, &t.dfdx}}});
    const SparseMatrix expected = c.model->mass() - dt * t.dfdv - dt * dt * t.dfdx;
    EXPECT_LE(relative_error(sum, MatrixX(gather(c.dofs(), expected))), 1e-15);
  }
}

TEST(StepMatrix, TakesTermsWithoutEntriesAndAnotherPattern) {
  const Cantilever c(1), other(2);
  const SparseMatrix none;
  const Tangent t = c.model->tangent(c.bent(), TangentKind::exact);
  StepMatrix matrix(c.dofs());
  EXPECT_LE(relative_error(MatrixX(matrix.sum({{{2, &c.model->mass()}, {1, &none}, {0, &none}}})),
                           MatrixX(2 * gather(c.dofs(), c.model->mass()))),
            1e-15);
  EXPECT_LE(relative_error(MatrixX(matrix.sum({{{0, &c.model->mass()}, {1, &none}, {1, &t.dfdx}}})),
                           MatrixX(gather(c.dofs(), t.dfdx))),
            1e-15);
}

class StepSolvers : public testing::TestWithParam<std::string> {};
std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const BackendInfo& b : step_solver_backends()) out.push_back(b.name);
  return out;
}
INSTANTIATE_TEST_SUITE_P(All, StepSolvers, testing::ValuesIn(names()), [](const auto& p) { return p.param; });

// Springs between far nodes, put beside the matrix: the solution is that of the sum, and the next one is without them.
TEST_P(StepSolvers, SolveWithEntriesBesideTheMatrix) {
  const Cantilever c(4);
  const auto solver = make_step_solver(GetParam(), {free_positions(*c.model, c.dofs()), 1e-10});
  StepMatrix matrix(c.dofs());
  const Tangent t = c.model->tangent(c.bent(), TangentKind::definite);
  const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {-0.02, &t.dfdv}, {-4e-4, &t.dfdx}}});
  const auto last = static_cast<int>(A.rows()) - 1;
  const double stiff = 10 * A.coeff(0, 0);
  const MatrixEntries spring{{0, 0, stiff}, {0, last, -stiff}, {last, 0, -stiff}, {last, last, stiff}};
  const VectorX rhs = random_vector(A.rows(), 1);
  VectorX x;
  solver->put_beside(spring);
  SparseMatrix more(A.rows(), A.cols());
  more.setFromTriplets(spring.begin(), spring.end());
  const MatrixX sum = MatrixX(A) + MatrixX(more);
  ASSERT_TRUE(solver->solve(A, rhs, x));
  EXPECT_LE((sum * x - rhs).norm(), 1e-9 * rhs.norm());
  EXPECT_GT((A * x - rhs).norm(), 1e-3 * rhs.norm());
  ASSERT_TRUE(solver->solve(A, rhs, x));
  EXPECT_LE((A * x - rhs).norm(), 1e-9 * rhs.norm());
}

// Springs that are a million times as stiff as the body, and ones that alone hold it in place.
TEST_P(StepSolvers, SolveWhatOnlyTheEntriesBesideItHold) {
  if (GetParam() == "pcg") GTEST_SKIP() << "its coarse space is the body's own";
  SparseMatrix A(6, 6);  // two nodes joined by springs along x, y and z, that may move together
  for (int c = 0; c < 3; ++c)
    for (const auto& [i, j] : {std::pair{c, c}, {c + 3, c + 3}, {c, c + 3}, {c + 3, c}})
      A.insert(i, j) = i == j ? 1 : -1;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if (A.coeff(i, j) == 0) A.coeffRef(i, j) = 0;  // whole blocks
  A.makeCompressed();
  const auto solver = make_step_solver(GetParam(), {VectorX::LinSpaced(6, 0, 1), 1e-10});
  const MatrixEntries held{{0, 0, 1e6}, {1, 1, 1.0}, {2, 2, 1e-2}};
  SparseMatrix more(6, 6);
  more.setFromTriplets(held.begin(), held.end());
  const VectorX rhs = random_vector(6, 3);
  VectorX x = VectorX::Zero(6);
  solver->put_beside(held);
  ASSERT_TRUE(solver->solve(A, rhs, x));
  EXPECT_LE((MatrixX(A) * x + more * x - rhs).norm(), 1e-8 * rhs.norm());
}

TEST_P(StepSolvers, SolveTheSystemsOfABendingBody) {
  const Cantilever c(3);
  const auto solver = make_step_solver(GetParam(), {free_positions(*c.model, c.dofs()), 1e-10});
  StepMatrix matrix(c.dofs());
  VectorX x;
  for (int i = 1; i <= 5; ++i) {  // matrices that change, as in successive steps
    State s = c.bent();
    s.x = c.model->mesh().x + 0.2 * i * (s.x - c.model->mesh().x);
    const Tangent t = c.model->tangent(s, TangentKind::definite);
    const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {-0.02, &t.dfdv}, {-4e-4, &t.dfdx}}});
    const VectorX rhs = random_vector(A.rows(), i);
    ASSERT_TRUE(solver->solve(A, rhs, x));
    EXPECT_LE((A * x - rhs).norm(), 1.01e-10 * rhs.norm());
    EXPECT_LE(relative_error(x, MatrixX(A).llt().solve(rhs)), 1e-8);
  }
}

TEST_P(StepSolvers, SolveRoughlyToAThousandth) {
  const Cantilever c(3);
  const auto solver = make_step_solver(GetParam(), {free_positions(*c.model, c.dofs()), 1e-10});
  StepMatrix matrix(c.dofs());
  const Tangent t = c.model->tangent(c.bent(), TangentKind::definite);
  const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {-0.02, &t.dfdv}, {-4e-4, &t.dfdx}}});
  const VectorX rhs = random_vector(A.rows(), 1);
  VectorX x, rough;
  ASSERT_TRUE(solver->solve_roughly(A, rhs, rough));
  EXPECT_LE((A * rough - rhs).norm(), 1.01e-3 * rhs.norm());
  const int few = solver->iterations();
  ASSERT_TRUE(solver->solve(A, rhs, x));
  EXPECT_LE((A * x - rhs).norm(), 1.01e-10 * rhs.norm());
  if (solver->iterations() > 0) {  // of an iterative one
    EXPECT_LT(2 * few, solver->iterations());
  }
}

TEST_P(StepSolvers, SayWhenTheMatrixIsNotPositiveDefinite) {
  const Cantilever c(2);
  StepMatrix matrix(c.dofs());
  const Tangent t = c.model->tangent(rest_state(*c.model), TangentKind::exact);
  const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {0, &t.dfdv}, {1e-2, &t.dfdx}}});  // the wrong sign
  VectorX x;
  EXPECT_FALSE(make_step_solver(GetParam(), {free_positions(*c.model, c.dofs()), 1e-6})
                   ->solve(A, random_vector(A.rows(), 1), x));
}

/// A plate as thin as foil at rest: conjugate gradients give up on its slivers, the matrix is definite.
TEST(Automatic, FactorsWhereConjugateGradientsDoNotConverge) {
  Mesh plate = kuhn_block(24, 24, 1, 0.01);
  for (int i = 2; i < plate.x.size(); i += 3) plate.x[i] *= 1e-2;
  std::vector<int> held;
  for (int i = 0; i < plate.num_nodes(); ++i)
    if (plate.x[3 * i] < 1e-9) held.push_back(i);
  const auto model = make_model("fem", plate, {.young = 1e5, .fixed_nodes = held});
  const FreeDofs dofs = make_free_dofs(plate.num_nodes(), held);
  ASSERT_GE(dofs.size(), 3000);  // small bodies are factored anyway
  const Tangent t = model->tangent(rest_state(*model), TangentKind::exact);
  StepMatrix matrix(dofs);
  const StepSolverOptions options{free_positions(*model, dofs), 1e-6};
  const auto automatic = make_step_solver("automatic", options);
  VectorX x;
  const SparseMatrix wrong_sign = matrix.sum({{{0, &model->mass()}, {0, &t.dfdv}, {1, &t.dfdx}}});
  const SparseMatrix K = matrix.sum({{{0, &model->mass()}, {0, &t.dfdv}, {-1, &t.dfdx}}});
  const VectorX rhs = random_vector(K.rows(), 1);
  EXPECT_FALSE(make_step_solver("pcg", options)->solve(K, rhs, x));
  for (const bool is_first : {true, false}) {
    x.resize(0);
    ASSERT_TRUE(automatic->solve(K, rhs, x));
    EXPECT_LE((K * x - rhs).norm(), 1e-6 * rhs.norm());
    EXPECT_EQ(automatic->iterations() > 0, is_first);  // tried no second time
    EXPECT_FALSE(automatic->solve(wrong_sign, rhs, x));
  }
}

TEST(Pcg, StartsFromTheGuessAndTakesTheSameStepsAgain) {
  const Cantilever c(3);
  StepMatrix matrix(c.dofs());
  const Tangent t = c.model->tangent(c.bent(), TangentKind::definite);
  const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {-0.02, &t.dfdv}, {-4e-4, &t.dfdx}}});
  const VectorX rhs = random_vector(A.rows(), 1);
  VectorX once, again;
  for (VectorX* x : {&once, &again}) {
    const auto solver = make_step_solver("pcg", {free_positions(*c.model, c.dofs()), 1e-8});
    ASSERT_TRUE(solver->solve(A, rhs, *x));
    EXPECT_GT(solver->iterations(), 5);
    ASSERT_TRUE(solver->solve(A, rhs, *x));
    EXPECT_EQ(solver->iterations(), 0);
  }
  EXPECT_EQ(once, again);
}

/// Without it they double with the cells, 136 and 279; with it 56 and 70.
TEST(Pcg, CoarseProblemKeepsTheIterationsFromGrowingWithTheMesh) {
  const auto iterations = [](int cells) {
    const Cantilever c(cells);
    StepMatrix matrix(c.dofs());
    const Tangent t = c.model->tangent(rest_state(*c.model), TangentKind::definite);
    const SparseMatrix& A = matrix.sum({{{1, &c.model->mass()}, {-0.02, &t.dfdv}, {-4e-4, &t.dfdx}}});
    const auto solver = make_step_solver("pcg", {free_positions(*c.model, c.dofs()), 1e-8});
    VectorX x;
    EXPECT_TRUE(solver->solve(A, VectorX::Ones(A.rows()), x));
    return solver->iterations();
  };
  const int coarse = iterations(5), fine = iterations(10);
  std::printf("pcg: %d iterations with 5 cells across, %d with 10\n", coarse, fine);
  EXPECT_LE(fine, 1.4 * coarse);
}

TEST(Newton, FindsTheEquilibriumWhereForcesVanish) {
  for (const char* material : {"linear", "corotational", "stvk", "neo_hookean"}) {
    const Cantilever c(2, material);
    const auto stepper = make_integrator("quasistatic");
    State s = rest_state(*c.model);
    stepper->step(*c.model, VectorX::Zero(s.x.size()), 0.1, s);
    EXPECT_EQ(stepper->statistics().not_converged, 0);
    VectorX f, weight;
    c.model->force(rest_state(*c.model), weight);
    c.model->force(s, f);
    EXPECT_LE(gather(c.dofs(), f).norm(), 1e-8 * weight.norm()) << material;
    EXPECT_GT((s.x - c.model->mesh().x).lpNorm<Eigen::Infinity>(), 0.05);  // far from where it started
  }
}

TEST(Newton, SolvesBackwardEulerToTheEndWhereOneLinearStepDoesNot) {
  const Cantilever c(2, "neo_hookean");
  const auto residual_of = [&](const char* integrator) {
    State s = rest_state(*c.model);
    const State before = s;
    const double dt = 0.1;
    make_integrator(integrator)->step(*c.model, VectorX::Zero(s.x.size()), dt, s);
    VectorX f;
    c.model->force(s, f);
    return gather(c.dofs(), VectorX(c.model->mass() * (s.v - before.v) - dt * f)).norm();
  };
  EXPECT_LE(residual_of("newton_euler"), 1e-9 * residual_of("implicit_euler"));
}

TEST(Newton, SaysThatAFloatingBodyHasNoEquilibrium) {
  const auto model = make_model("fem", kuhn_block(1, 1, 1, 0.1), {.gravity = Vec3(0, 0, -9.81)});
  State s = rest_state(*model);
  EXPECT_THROW(make_integrator("quasistatic")->step(*model, VectorX::Zero(s.x.size()), 0.1, s), RunError);
}

}  // namespace
}  // namespace kt
