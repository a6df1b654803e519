// Products with a matrix in panels against sums in the order that is promised, so on every processor the same bits.
#include <gtest/gtest.h>

#include "core/linear/dense/panel_product.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

/// The promised sum: even columns and odd ones, each in their order.
VectorX summed(const MatrixX& A, const VectorX& x) {
  VectorX out(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    double sum[2] = {0, 0};
    for (Eigen::Index k = 0; k < A.cols(); ++k) sum[k % 2] += x[k] * A(i, k);
    out[i] = sum[0] + sum[1];
  }
  return out;
}

TEST(PanelMatrix, GivesTheBitsOfThePromisedSum) {
  for (const int rows : {1, 3, 31, 32, 33, 96, 129, 220})
    for (const int cols : {1, 2, 7, 148, 221}) {
      const MatrixX A = random_vector(rows * cols, static_cast<unsigned>(rows + cols)).reshaped(rows, cols);
      const VectorX x = random_vector(cols, 3);
      VectorX found;
      PanelMatrix(A).multiply(x, found);
      const VectorX wanted = summed(A, x);
      ASSERT_EQ(found.size(), rows);
      for (int i = 0; i < rows; ++i) ASSERT_EQ(found[i], wanted[i]) << rows << " x " << cols << ", row " << i;
    }
}

TEST(PanelMatrix, OfNothingIsNothing) {
  EXPECT_TRUE(PanelMatrix().empty());
  VectorX out;
  PanelMatrix(MatrixX::Zero(5, 0)).multiply(VectorX(0), out);
  EXPECT_EQ(out, VectorX::Zero(5));
}

}  // namespace
}  // namespace kt
