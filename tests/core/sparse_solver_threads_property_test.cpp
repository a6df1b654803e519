// Bodies that are solved side by side, as by the maps of `kilotouch stability`.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

/// Of a grid of n x n x n nodes, three unknowns each: so large that its factors are made of dense blocks.
SparseMatrix grid_matrix(int n) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto id = [n](int i, int j, int k) { return (i * n + j) * n + k; };
  const auto couple = [&](int a, int b) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const double value = r == c ? -1 : -0.1;
        entries.emplace_back(3 * a + r, 3 * b + c, value);
        entries.emplace_back(3 * b + c, 3 * a + r, value);
      }
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            entries.emplace_back(3 * id(i, j, k) + r, 3 * id(i, j, k) + c, r == c ? 7.5 : 0.0);
        if (i + 1 < n) couple(id(i, j, k), id(i + 1, j, k));
        if (j + 1 < n) couple(id(i, j, k), id(i, j + 1, k));
        if (k + 1 < n) couple(id(i, j, k), id(i, j, k + 1));
      }
  const int size = 3 * n * n * n;
  SparseMatrix out(size, size);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

TEST(SparseSolver, ThreadsDoNotDisturbOneAnother) {
  const SparseMatrix A = grid_matrix(9);
  const MatrixX b = MatrixX::Ones(A.rows(), 8);
  std::atomic<int> wrong{0};
  const auto work = [&] {
    for (int run = 0; run < 20; ++run) {
      const auto solver = make_sparse_solver();
      if (!solver->factor(A) || (A * solver->solve(b) - b).norm() > 1e-9 * b.norm()) ++wrong;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace kt
