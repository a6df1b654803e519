// Our own eigen-solver and Cholesky inverses against Eigen's.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

#include "core/base/error.hpp"
#include "core/linear/dense/dense_cholesky.hpp"
#include "core/linear/dense/dense_product.hpp"
#include "core/linear/dense/symmetric_eigen.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-13;  // of the largest entry, times the size

void expect_eigen(const MatrixX& A) {
  const Eigen::Index n = A.rows();
  const double tolerance = kRoundoff * static_cast<double>(n) * std::max(1e-300, A.cwiseAbs().maxCoeff());
  const SymmetricEigen found = symmetric_eigen(A);
  ASSERT_EQ(found.values.size(), n);
  EXPECT_LE((found.vectors.transpose() * found.vectors - MatrixX::Identity(n, n)).cwiseAbs().maxCoeff(),
            kRoundoff * static_cast<double>(n));
  EXPECT_LE((A * found.vectors - found.vectors * found.values.asDiagonal()).cwiseAbs().maxCoeff(), tolerance) << n;
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(A);
  EXPECT_LE((found.values - eigen.eigenvalues()).cwiseAbs().maxCoeff(), tolerance) << n;
  for (Eigen::Index i = 1; i < n; ++i) EXPECT_LE(found.values[i - 1], found.values[i]);
}

TEST(SymmetricEigen, AgreesWithEigensSolver) {
  for (int n : {1, 2, 3, 4, 7, 16, 33, 64, 150}) {
    const MatrixX R = random_vector(n * n, static_cast<unsigned>(n)).reshaped(n, n);
    expect_eigen(R + R.transpose());
    expect_eigen(1e9 * random_positive_definite(n, 2));
    VectorX spread = VectorX::LinSpaced(n, -3, 9);
    spread = spread.unaryExpr([](double x) { return std::pow(10, x); });
    const MatrixX turned = Eigen::SelfAdjointEigenSolver<MatrixX>(MatrixX(R + R.transpose())).eigenvectors();
    const MatrixX wide = turned * spread.asDiagonal() * turned.transpose();
    expect_eigen(0.5 * (wide + wide.transpose()));
  }
}

TEST(SymmetricEigen, TakesMatricesWithEqualValuesZerosAndNone) {
  for (int n : {1, 2, 5, 40}) {
    expect_eigen(MatrixX::Identity(n, n));
    expect_eigen(MatrixX::Zero(n, n));
    expect_eigen(MatrixX::Ones(n, n));
    expect_eigen(MatrixX(VectorX::LinSpaced(n, 4, -4).asDiagonal()));
  }
  EXPECT_EQ(symmetric_eigen(MatrixX(0, 0)).values.size(), 0);
}

TEST(SymmetricEigen, SaysThatAMatrixIsNotFinite) {
  MatrixX A = MatrixX::Identity(5, 5);
  A(3, 1) = A(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(symmetric_eigen(A), RunError);
}

TEST(InverseFactor, IsThatOfEigensFactor) {
  for (int n : {1, 3, 15, 16, 17, 40, 133}) {
    const MatrixX A = random_positive_definite(n, 5);
    const MatrixX L = A.llt().matrixL();
    const auto inverse = inverse_factor(A);
    ASSERT_TRUE(inverse);
    EXPECT_LE(relative_error(*inverse * L, MatrixX::Identity(n, n)), 1e-12) << n;
    EXPECT_LE(relative_error(invert_lower(L) * L, MatrixX::Identity(n, n)), 1e-12) << n;
    EXPECT_LE(relative_error(inverse_from(*inverse) * A, MatrixX::Identity(n, n)), 1e-11) << n;
    EXPECT_EQ(MatrixX(inverse->triangularView<Eigen::StrictlyUpper>()).norm(), 0) << n;
  }
  EXPECT_EQ(inverse_factor(MatrixX(0, 0))->size(), 0);
}

TEST(InverseFactor, TimesItselfHasTheBitsOfAFullProduct) {
  for (int n : {1, 15, 17, 33, 127, 128, 129, 300}) {
    const RowMatrix lower = random_positive_definite(n, 7).triangularView<Eigen::Lower>();
    EXPECT_EQ(product_with_itself(lower), symmetric_product(ColumnGroups(lower), ColumnGroups(lower))) << n;
  }
}

TEST(InverseFactor, IsNoneOfWhatIsNotPositiveDefinite) {
  for (int n : {1, 20, 50}) {
    MatrixX A = random_positive_definite(n, 6);
    A -= 1.01 * Eigen::SelfAdjointEigenSolver<MatrixX>(A).eigenvalues()[0] * MatrixX::Identity(n, n);
    EXPECT_FALSE(inverse_factor(A)) << n;
    A(n - 1, n - 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(inverse_factor(A)) << n;
  }
  // A pivot that is nearly nothing beside its own diagonal entry.
  MatrixX A = MatrixX::Ones(2, 2);
  A(1, 1) += 1e-8;
  EXPECT_TRUE(inverse_factor(A));
  EXPECT_FALSE(inverse_factor(A, 1e-6));
}

}  // namespace
}  // namespace kt
