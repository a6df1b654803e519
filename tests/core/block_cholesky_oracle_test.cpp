// The own solver for matrices in whole node blocks against dense Cholesky, and its symbolic part against the rules that
// it is made by.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/linear/sparse_solver.hpp"
#include "core/linear/supernodes.hpp"
#include "core/linear/trailing_inverse.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // relative, condition below 1000

/// A chain, a plane or a cube of nodes, neighbours joined by random blocks; positive definite.
SparseMatrix grid_matrix(int x, int y, int z, unsigned seed) {
  const int n = x * y * z;
  std::vector<Eigen::Triplet<double>> entries;
  const VectorX random = random_vector(9 * 8 * n, seed);
  MatrixX sums = MatrixX::Zero(3 * n, 1);
  int next = 0;
  const auto number = [&](int i, int j, int k) { return i + x * (j + y * k); };
  for (int k = 0; k < z; ++k)
    for (int j = 0; j < y; ++j)
      for (int i = 0; i < x; ++i)
        for (const auto& [di, dj, dk] : {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}}) {
          if (i + di >= x || j + dj >= y || k + dk >= z) continue;
          const int a = number(i, j, k), b = number(i + di, j + dj, k + dk);
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
              const double value = random[next++ % random.size()];
              entries.emplace_back(3 * a + r, 3 * b + c, value);
              entries.emplace_back(3 * b + c, 3 * a + r, value);
              sums(3 * a + r) += std::abs(value);
              sums(3 * b + c) += std::abs(value);
            }
        }
  for (int a = 0; a < n; ++a)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        entries.emplace_back(3 * a + r, 3 * a + c, r == c ? 1.1 * sums(3 * a + r) + 0.5 : 0.01 * (r + c));
  SparseMatrix out(3 * n, 3 * n);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

struct Grid {
  int x, y, z;
};
constexpr Grid kGrids[]{{1, 1, 1}, {2, 1, 1}, {7, 1, 1}, {40, 1, 1}, {6, 5, 1}, {13, 11, 1}, {5, 6, 7}};

/// 1, 2, .. 40 right-hand sides: a part of a group of columns, one, and several.
TEST(BlockCholesky, SolvesAsDenseAlgebraDoes) {
  for (const Grid& g : kGrids) {
    const SparseMatrix m = grid_matrix(g.x, g.y, g.z, 7);
    const int n = static_cast<int>(m.rows());
    const Eigen::LLT<MatrixX> dense{MatrixX(m)};
    for (const bool with_last : {false, true}) {
      const auto solver = make_block_solver();
      if (with_last) solver->order_last({n / 6, 0, n / 3 - 1});
      ASSERT_TRUE(solver->factor(m));
      for (const int columns : {1, 3, 16, 40}) {
        const MatrixX b = random_vector(n * columns, 5).reshaped(n, columns);
        EXPECT_LE(relative_error(solver->solve(b), dense.solve(b)), kRoundoff) << n << " " << columns;
        RowMatrix wide = RowMatrix::Constant(n, columns + 2, 8);
        wide.middleCols(1, columns) = b;
        solver->solve_in_place(wide.middleCols(1, columns));
        EXPECT_EQ(wide.middleCols(1, columns), RowMatrix(solver->solve(b)));
        EXPECT_EQ(wide.col(0), VectorX::Constant(n, 8));  // the columns beside stay
        EXPECT_EQ(wide.col(columns + 1), VectorX::Constant(n, 8));
      }
      // Loads on few nodes leave most supernodes out on the way down.
      MatrixX unit = MatrixX::Zero(n, 3);
      unit.middleRows<3>(3 * (n / 6)).setIdentity();
      EXPECT_LE(relative_error(solver->solve(unit), dense.solve(unit)), kRoundoff) << n;
    }
  }
}

/// Ordered last, some of them or none of them, and of matrices without blocks.
TEST(BlockCholesky, HasTheTrailingBlockOfTheInverse) {
  for (const Grid& g : kGrids) {
    const SparseMatrix m = grid_matrix(g.x, g.y, g.z, 9);
    const int n = static_cast<int>(m.rows()), nodes = n / 3;
    const MatrixX inverse = Eigen::LLT<MatrixX>{MatrixX(m)}.solve(MatrixX::Identity(n, n));
    for (const int count : {1, std::max(1, nodes / 3), nodes}) {
      const auto expected = inverse.bottomRightCorner(3 * count, 3 * count);
      std::vector<int> last;
      for (int i = nodes - count; i < nodes; ++i) last.push_back(i);
      const auto solver = make_block_solver(), other = make_block_solver();
      solver->order_last(last);
      ASSERT_TRUE(solver->factor(m));
      EXPECT_LE(relative_error(trailing_inverse(*solver, n, 3 * count), expected), kRoundoff) << n << ' ' << count;
      SparseMatrix points(2 * count, 3 * count);  // two numbers of each node, and the next one's
      for (int i = 0; i < 2 * count; ++i) {
        points.insert(i, i) = 1 + i % 3;
        if (i + 4 < 3 * count) points.insert(i, i + 4) = -0.3;
      }
      const MatrixX seen = points * MatrixX(expected) * points.transpose();
      EXPECT_LE(relative_error(trailing_inverse(*solver, n, points), seen), kRoundoff) << n << ' ' << count;
      other->order_last({0});
      ASSERT_TRUE(other->factor(m));
      EXPECT_LE(relative_error(trailing_inverse(*other, n, 3 * count), expected), kRoundoff) << n << ' ' << count;
      EXPECT_LE(relative_error(trailing_inverse(*other, n, points), seen), kRoundoff) << n << ' ' << count;
      ASSERT_TRUE(other->factor(SparseMatrix(m.triangularView<Eigen::Lower>())));
      EXPECT_LE(relative_error(trailing_inverse(*other, n, 3 * count), expected), kRoundoff) << n << ' ' << count;
    }
  }
}

TEST(BlockCholesky, FactorsAgainTakesAnalysesAndSaysWhatIsNotDefinite) {
  const SparseMatrix m = grid_matrix(4, 5, 3, 2), other = grid_matrix(4, 3, 5, 3);
  const VectorX b = random_vector(180, 4);
  const auto first = make_block_solver(), second = make_block_solver(), alone = make_block_solver();
  second->take_analysis(*first);  // there is none yet
  ASSERT_TRUE(first->factor(m));
  second->take_analysis(*first);
  ASSERT_TRUE(second->factor(SparseMatrix(2 * m)));
  ASSERT_TRUE(alone->factor(SparseMatrix(2 * m)));
  EXPECT_EQ(second->solve(b), alone->solve(b));
  ASSERT_TRUE(second->factor(other));
  EXPECT_LE(relative_error(MatrixX(other) * second->solve(b), b), kRoundoff);
  SparseMatrix bad = m;
  bad.coeffRef(17, 17) = -1;
  EXPECT_FALSE(first->factor(bad));
  ASSERT_TRUE(first->factor(m));
  EXPECT_LE(relative_error(MatrixX(m) * first->solve(b), b), kRoundoff);
  const SparseMatrix lower = m.triangularView<Eigen::Lower>();  // in whole blocks no longer: the general solver's
  ASSERT_TRUE(second->factor(lower));
  EXPECT_LE(relative_error(MatrixX(m) * second->solve(b), b), kRoundoff);
}

/// Every number of the dense factor that is not zero has its place in a supernode.
TEST(Supernodes, CoverTheFactorInTheirOrder) {
  for (const Grid& g : kGrids) {
    const SparseMatrix m = grid_matrix(g.x, g.y, g.z, 3);
    const int nodes = static_cast<int>(m.rows()) / 3;
    const std::vector<int> last{nodes / 2};
    const Supernodes found = find_supernodes(node_neighbours(m), last);
    ASSERT_EQ(static_cast<int>(found.order.size()), nodes);
    std::vector<char> seen(found.order.size(), 0);
    for (int i : found.order) ++seen[i];
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), nodes);
    std::vector<int> rows;
    for (int i : found.order) rows.insert(rows.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    const MatrixX L = Eigen::LLT<MatrixX>(MatrixX(m)(rows, rows)).matrixL();
    std::vector<std::vector<char>> has(nodes, std::vector<char>(nodes, 0));
    int first = 0;
    for (const Supernode& s : found.nodes) {
      EXPECT_EQ(s.first, first);
      first += s.count;
      EXPECT_TRUE(std::is_sorted(s.below.begin(), s.below.end()));
      for (int c = s.first; c < first; ++c) {
        for (int r = c; r < first; ++r) has[r][c] = 1;
        for (int r : s.below) has[r][c] = 1;
      }
      for (const Supernode::Run& run : s.runs)
        for (int i = run.from; i < static_cast<int>(s.below.size()); ++i) {
          const Supernode& to = found.nodes[run.target];
          const int row = run.rows[i - run.from];
          EXPECT_EQ(row < to.count ? to.first + row : to.below[row - to.count], s.below[i]);
        }
    }
    EXPECT_EQ(first, nodes);
    for (int r = 0; r < nodes; ++r)
      for (int c = 0; c <= r; ++c) EXPECT_TRUE(has[r][c] || (L.block<3, 3>(3 * r, 3 * c).isZero(0))) << r << " " << c;
  }
}

}  // namespace
}  // namespace kt
