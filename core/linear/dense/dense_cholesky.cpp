#include "core/linear/dense/dense_cholesky.hpp"

#include <cmath>

#include "core/linear/dense/dense_product.hpp"

namespace kt {
namespace {

// Blocks of kGroup rows and columns; the last is filled up with the identity.
constexpr Eigen::Index kBlock = kGroup;
using Block = Eigen::Matrix<double, kBlock, kBlock, Eigen::RowMajor>;

Eigen::Index filled_up(Eigen::Index n) { return (n + kBlock - 1) / kBlock * kBlock; }

RowMatrix filled_up(const MatrixX& lower) {
  const Eigen::Index n = lower.rows();
  RowMatrix out = RowMatrix::Identity(filled_up(n), filled_up(n));
  out.topLeftCorner(n, n).triangularView<Eigen::Lower>() = lower.triangularView<Eigen::Lower>();
  return out;
}

/// A block's own factor, in place; its strict upper triangle becomes zero.
bool factor_block(Block& a, const double* least) {
  for (Eigen::Index c = 0; c < kBlock; ++c) {
    for (Eigen::Index k = 0; k < c; ++k) {
      const double x = a(c, k);
      for (Eigen::Index r = c; r < kBlock; ++r) a(r, c) -= a(r, k) * x;
    }
    if (!(a(c, c) > least[c])) return false;
    const double root = std::sqrt(a(c, c)), inverse = 1 / root;
    a(c, c) = root;
    for (Eigen::Index r = c + 1; r < kBlock; ++r) a(r, c) *= inverse;
    for (Eigen::Index r = 0; r < c; ++r) a(r, c) = 0;
  }
  return true;
}

Block invert_block(const Block& l) {
  Block out = Block::Zero();
  for (Eigen::Index r = 0; r < kBlock; ++r) {
    const double inverse = 1 / l(r, r);
    for (Eigen::Index k = 0; k < r; ++k)
      for (Eigen::Index c = 0; c <= k; ++c) out(r, c) -= l(r, k) * out(k, c);
    for (Eigen::Index c = 0; c < r; ++c) out(r, c) *= inverse;
    out(r, r) = inverse;
  }
  return out;
}

/// out = A B for whole blocks: A (kBlock x count) and B (count x kBlock) with rows that far apart.
void block_product(const double* A, Eigen::Index a_row, const double* B, Eigen::Index b_row, Eigen::Index count,
                   double* out) {
  for (Eigen::Index i = 0; i < kBlock; i += kTileRows)
    product_tile(A + a_row * i, a_row, 1, B, b_row, count, out + kBlock * i);
}

/// The factor below the diagonal, in place; `inverses`: of its diagonal blocks.
bool factor(RowMatrix& L, std::vector<Block>& inverses, double least) {
  const Eigen::Index n = L.rows();
  std::vector<double> right(static_cast<std::size_t>(kBlock * n));  // block row of L, turned
  double tile[kTileRows * kBlock];
  for (Eigen::Index j = 0; j < n; j += kBlock) {
    double smallest[kBlock];
    for (Eigen::Index c = 0; c < kBlock; ++c) {
      smallest[c] = std::max(0.0, least * L(j + c, j + c));
      for (Eigen::Index k = 0; k < j; ++k) right[static_cast<std::size_t>(kBlock * k + c)] = L(j + c, k);
    }
    for (Eigen::Index i = j; i < n; i += kTileRows) {
      product_tile(L.data() + n * i, n, 1, right.data(), kBlock, j, tile);
      L.block<kTileRows, kBlock>(i, j) -= Eigen::Map<Eigen::Matrix<double, kTileRows, kBlock, Eigen::RowMajor>>(tile);
    }
    Block diagonal = L.block<kBlock, kBlock>(j, j);
    if (!factor_block(diagonal, smallest)) return false;
    L.block<kBlock, kBlock>(j, j) = diagonal;
    inverses.push_back(invert_block(diagonal));
    const Block turned = inverses.back().transpose();
    for (Eigen::Index i = j + kBlock; i < n; i += kTileRows) {
      product_tile(L.data() + n * i + j, n, 1, turned.data(), kBlock, kBlock, tile);
      L.block<kTileRows, kBlock>(i, j) = Eigen::Map<Eigen::Matrix<double, kTileRows, kBlock, Eigen::RowMajor>>(tile);
    }
  }
  return true;
}

/// Block row by block row: row I of L^-1 is -L_II^-1 (L_I0 .. L_I,I-1) of the rows above.
RowMatrix invert(const RowMatrix& L, const std::vector<Block>& inverses) {
  const Eigen::Index n = L.rows();
  RowMatrix out = RowMatrix::Zero(n, n);
  Block sum, part;
  for (Eigen::Index row = 0; row < n; row += kBlock) {
    const Block& own = inverses[static_cast<std::size_t>(row / kBlock)];
    for (Eigen::Index column = 0; column < row; column += kBlock) {
      block_product(L.data() + n * row + column, n, out.data() + n * column + column, n, row - column, sum.data());
      block_product(own.data(), kBlock, sum.data(), kBlock, kBlock, part.data());
      out.block<kBlock, kBlock>(row, column) = -part;
    }
    out.block<kBlock, kBlock>(row, row) = own;
  }
  return out;
}

}  // namespace

std::optional<RowMatrix> inverse_factor(const MatrixX& A, double least) {
  RowMatrix L = filled_up(A);
  std::vector<Block> inverses;
  if (!factor(L, inverses, least)) return {};
  return invert(L, inverses).topLeftCorner(A.rows(), A.cols());
}

bool is_positive_definite(const MatrixX& A) {
  RowMatrix L = filled_up(A);
  std::vector<Block> inverses;
  return factor(L, inverses, 0);
}

RowMatrix invert_lower(const MatrixX& L) {
  const RowMatrix whole = filled_up(L);
  std::vector<Block> inverses;
  for (Eigen::Index j = 0; j < whole.rows(); j += kBlock)
    inverses.push_back(invert_block(Block(whole.block<kBlock, kBlock>(j, j))));
  return invert(whole, inverses).topLeftCorner(L.rows(), L.cols());
}

MatrixX inverse_from(const RowMatrix& inverse_factor) { return product_with_itself(inverse_factor); }

}  // namespace kt
