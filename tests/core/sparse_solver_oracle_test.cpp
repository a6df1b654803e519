// The sparse solver of this build against dense Cholesky.
#include "core/linear/copied_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // relative, condition below 100

/// Positive definite with a few random entries below the diagonal in each column.
SparseMatrix random_sparse(int n, unsigned seed, int coupled = 3) {
  const VectorX r = random_vector(2 * coupled * n, seed);
  MatrixX a = MatrixX::Zero(n, n);
  for (int k = 0; k < coupled * n; ++k) a(k % n, static_cast<int>((r[2 * k] + 1) / 2 * n)) += r[2 * k + 1];
  MatrixX m = a + a.transpose();
  m.diagonal().array() += m.cwiseAbs().rowwise().sum().maxCoeff() + 0.1;
  return m.sparseView();
}

TEST(SparseSolver, SolvesOneAndManyRightHandSidesAsDenseAlgebraDoes) {
  for (int n : {1, 2, 30, 300}) {
    const SparseMatrix m = random_sparse(n, static_cast<unsigned>(n));
    const auto solver = make_sparse_solver();
    ASSERT_TRUE(solver->factor(m));
    for (int columns : {1, 7}) {
      const MatrixX b = random_vector(n * columns, 5).reshaped(n, columns);
      const MatrixX x = solver->solve(b);
      EXPECT_LE(relative_error(x, MatrixX(m).llt().solve(b)), kRoundoff) << n;
      EXPECT_LE(relative_error(x, Eigen::SimplicialLDLT<SparseMatrix>(m).solve(b)), kRoundoff) << n;
    }
  }
}

/// Of nodes that are neighbours where the graph has entries.
SparseMatrix in_node_blocks(const SparseMatrix& graph) {
  Mat3 block;
  block << 2, 0.3, -0.2, 0.3, 1.5, 0.1, -0.2, 0.1, 1;
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < 3 * graph.cols(); ++c)
    for (SparseMatrix::InnerIterator it(graph, c / 3); it; ++it)
      for (int r = 0; r < 3; ++r)
        entries.emplace_back(3 * static_cast<int>(it.row()) + r, c, it.value() * block(r, c % 3));
  SparseMatrix out(3 * graph.rows(), 3 * graph.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// Node blocks are ordered by their graph; a matrix that only nearly has them is not.
TEST(SparseSolver, SolvesMatricesOfNodeBlocksAndThoseThatNearlyAre) {
  for (int nodes : {1, 5, 60}) {
    const SparseMatrix blocks = in_node_blocks(random_sparse(nodes, static_cast<unsigned>(nodes)));
    SparseMatrix nearly = blocks;
    nearly.coeffRef(0, 1) = nearly.coeffRef(1, 0) = 0;
    nearly.prune(0.0);
    const VectorX b = random_vector(3 * nodes, 5);
    for (const SparseMatrix& m : {blocks, nearly}) {
      const auto solver = make_sparse_solver();
      ASSERT_TRUE(solver->factor(m));
      EXPECT_LE(relative_error(solver->solve(b), MatrixX(m).llt().solve(b)), kRoundoff) << nodes;
    }
  }
}

TEST(SparseSolver, ReadsOnlyTheLowerTriangle) {
  const SparseMatrix m = random_sparse(30, 1), lower = m.triangularView<Eigen::Lower>();
  const auto solver = make_sparse_solver();
  const VectorX b = random_vector(30, 2);
  ASSERT_TRUE(solver->factor(lower));
  EXPECT_LE(relative_error(m * solver->solve(b), b), kRoundoff);
}

TEST(SparseSolver, FactorsAgainWithNewValuesAndWithANewPatternOfTheSameSize) {
  const auto solver = make_sparse_solver();
  const VectorX b = random_vector(4, 2);
  SparseMatrix first(4, 4), second(4, 4);
  for (int i = 0; i < 4; ++i) first.insert(i, i) = second.insert(i, i) = 4 + i;
  first.insert(1, 0) = first.insert(0, 1) = 1;
  second.insert(3, 2) = second.insert(2, 3) = -2;  // as many entries, elsewhere
  first.makeCompressed();
  second.makeCompressed();
  for (const SparseMatrix& m : {first, SparseMatrix(2 * first), second, first, random_sparse(4, 3, 1)}) {
    ASSERT_TRUE(solver->factor(m));
    EXPECT_LE(relative_error(MatrixX(m) * solver->solve(b), b), kRoundoff);
  }
}

TEST(SparseSolver, TakesTheAnalysisOfAnotherAndSolvesAsIfItWereItsOwn) {
  const VectorX b = random_vector(300, 2);
  const SparseMatrix m = random_sparse(300, 3), other = random_sparse(300, 4);
  const auto first = make_sparse_solver(), second = make_sparse_solver(), alone = make_sparse_solver();
  second->take_analysis(*first);  // there is none yet
  ASSERT_TRUE(first->factor(m));
  second->take_analysis(*first);
  ASSERT_TRUE(second->factor(SparseMatrix(2 * m)));
  ASSERT_TRUE(alone->factor(SparseMatrix(2 * m)));
  EXPECT_EQ(second->solve(b), alone->solve(b));
  EXPECT_LE(relative_error(m * first->solve(b), b), kRoundoff);  // its factor is its own
  ASSERT_TRUE(second->factor(other));                            // of another pattern
  EXPECT_LE(relative_error(other * second->solve(b), b), kRoundoff);
  second->take_analysis(*first);
  ASSERT_TRUE(second->factor(m));
  EXPECT_EQ(second->solve(b), first->solve(b));
}

TEST(SparseSolver, CopiesHaveTheFactorAndGoOnByThemselves) {
  const VectorX b = random_vector(300, 2);
  const SparseMatrix rough = random_sparse(300, 3), other = random_sparse(300, 4);
  const SparseMatrix blocks = in_node_blocks(random_sparse(100, 5));
  for (const auto& make : {make_sparse_solver, make_block_solver})
    for (const SparseMatrix& m : {rough, blocks}) {
      const auto first = make();
      EXPECT_TRUE(copy_of(*first)->factor(m)) << "of one that has none";
      ASSERT_TRUE(first->factor(m));
      const VectorX expected = first->solve(b);
      const auto second = copy_of(*first), third = copy_of(*second);
      EXPECT_EQ(second->solve(b), expected);
      ASSERT_TRUE(first->factor(other));
      EXPECT_EQ(second->solve(b), expected);
      ASSERT_TRUE(second->factor(SparseMatrix(2 * m)));
      EXPECT_EQ(third->solve(b), expected);
      EXPECT_LE(relative_error(2 * m * second->solve(b), b), kRoundoff);
      EXPECT_LE(relative_error(other * first->solve(b), b), kRoundoff);
    }
}

TEST(SparseSolver, SaysWhenTheMatrixIsNotPositiveDefiniteAndRecovers) {
  const auto solver = make_sparse_solver();
  SparseMatrix m = random_sparse(30, 4);
  const SparseMatrix good = m;
  m.coeffRef(17, 17) = -1;
  EXPECT_FALSE(solver->factor(m));
  EXPECT_TRUE(solver->factor(good));
  const VectorX b = random_vector(30, 2);
  EXPECT_LE(relative_error(good * solver->solve(b), b), kRoundoff);
  EXPECT_FALSE(make_sparse_solver()->factor(-good));
}

}  // namespace
}  // namespace kt
