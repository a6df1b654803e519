// Complex symmetric block factors against LU with pivots.
#include "core/linear/dense/complex_symmetric.hpp"

#include <gtest/gtest.h>

#include "core/linear/dense/dense_solvers.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-11;  // relative, condition below 10^4

/// K - w^2 M in vibrations: numbers of both signs on the diagonal; damping full, of any size beside them.
TEST(ComplexSymmetric, SolvesAsLuDoes) {
  for (const int n : {1, 5, 16, 17, 40, 150})
    for (const double damped : {1e-3, 1.0, 100.0}) {
      const MatrixX root = random_vector(n * n, 3).reshaped(n, n);
      const MatrixX imaginary = damped * (root * root.transpose() / n + 0.1 * MatrixX::Identity(n, n));
      MatrixX real = MatrixX::Zero(n, n);
      for (int i = 0; i < n; ++i) real(i, i) = (i % 3 ? 1 : -1) * (1 + i);
      ComplexMatrix A(n, n);
      A.real() = real;
      A.imag() = imaginary;
      for (const int columns : {1, 12, 19}) {
        ComplexMatrix b(n, columns);
        b.real() = random_vector(n * columns, 5).reshaped(n, columns);
        b.imag() = random_vector(n * columns, 6).reshaped(n, columns);
        const ComplexMatrix x = ComplexSymmetric(real, imaginary).solve(b), expected = ComplexLu(A).solve(b);
        EXPECT_LE((x - expected).norm(), kRoundoff * expected.norm()) << n << " " << damped;
        EXPECT_LE((A * x - b).norm(), kRoundoff * b.norm()) << n << " " << damped;
      }
    }
}

/// At rest, or without damping: a diagonal.
TEST(ComplexSymmetric, SolvesADiagonalWithoutImaginaryPart) {
  const MatrixX real = MatrixX(VectorX::LinSpaced(21, -3, 7.5).asDiagonal()), none = MatrixX::Zero(21, 21);
  const ComplexMatrix b = ComplexMatrix::Ones(21, 2);
  EXPECT_LE((real.cast<std::complex<double>>() * ComplexSymmetric(real, none).solve(b) - b).norm(), kRoundoff);
}

}  // namespace
}  // namespace kt
