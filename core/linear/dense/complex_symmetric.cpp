#include "core/linear/dense/complex_symmetric.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear/dense/dense_product.hpp"

namespace kt {
namespace {

constexpr Eigen::Index kSide = kGroup;                // of a block
constexpr Eigen::Index kNumbers = kTileRows * kSide;  // of a tile

/// Real and imaginary part of numbers that are the same distances apart.
struct Source {
  const double *real, *imaginary;
};

/// Both parts of sum_k A(i, k) B(k, j), for a tile.
void complex_tile(const Source& a, std::ptrdiff_t a_row, std::ptrdiff_t a_step, const Source& b, std::ptrdiff_t count,
                  double* real, double* imaginary) {
  double twice[kNumbers], other[kNumbers];
  product_tile(a.real, a_row, a_step, b.real, kSide, count, real);
  product_tile(a.imaginary, a_row, a_step, b.imaginary, kSide, count, twice);
  product_tile(a.real, a_row, a_step, b.imaginary, kSide, count, imaginary);
  product_tile(a.imaginary, a_row, a_step, b.real, kSide, count, other);
  for (Eigen::Index e = 0; e < kNumbers; ++e) {
    real[e] -= twice[e];
    imaginary[e] += other[e];
  }
}

/// In place, by Gauss and Jordan with row pivots; rows of kSide numbers.
void invert_block(double* real, double* imaginary) {
  Eigen::Index from[kSide];
  for (Eigen::Index c = 0; c < kSide; ++c) {
    Eigen::Index pivot = c;
    const auto size_sq = [&](Eigen::Index r) {
      const double x = real[kSide * r + c], y = imaginary[kSide * r + c];
      return x * x + y * y;
    };
    for (Eigen::Index r = c + 1; r < kSide; ++r)
      if (size_sq(r) > size_sq(pivot)) pivot = r;
    from[c] = pivot;
    for (double* part : {real, imaginary})
      if (pivot != c) std::swap_ranges(part + kSide * c, part + kSide * (c + 1), part + kSide * pivot);
    const double scale = 1 / size_sq(c), p = real[kSide * c + c] * scale, q = -imaginary[kSide * c + c] * scale;
    real[kSide * c + c] = 1;
    imaginary[kSide * c + c] = 0;
    for (Eigen::Index k = 0; k < kSide; ++k) {
      const double x = real[kSide * c + k], y = imaginary[kSide * c + k];
      real[kSide * c + k] = x * p - y * q;
      imaginary[kSide * c + k] = x * q + y * p;
    }
    for (Eigen::Index r = 0; r < kSide; ++r) {
      if (r == c) continue;
      const double x = real[kSide * r + c], y = imaginary[kSide * r + c];
      real[kSide * r + c] = imaginary[kSide * r + c] = 0;
      for (Eigen::Index k = 0; k < kSide; ++k) {
        const double u = real[kSide * c + k], v = imaginary[kSide * c + k];
        real[kSide * r + k] -= x * u - y * v;
        imaginary[kSide * r + k] -= x * v + y * u;
      }
    }
  }
  for (Eigen::Index c = kSide; c-- > 0;)
    for (double* part : {real, imaginary})
      if (from[c] != c)
        for (Eigen::Index r = 0; r < kSide; ++r) std::swap(part[kSide * r + c], part[kSide * r + from[c]]);
}

/// Filled up to whole blocks with `diagonal` on the diagonal.
RowMatrix filled_up(const MatrixX& lower, double diagonal) {
  const Eigen::Index n = lower.rows(), all = (n + kSide - 1) / kSide * kSide;
  RowMatrix out = diagonal * RowMatrix::Identity(all, all);
  out.topLeftCorner(n, n).triangularView<Eigen::Lower>() = lower.triangularView<Eigen::Lower>();
  return out;
}

}  // namespace

ComplexSymmetric::ComplexSymmetric(const MatrixX& real, const MatrixX& imaginary)
    : size_(real.rows()), lower_{filled_up(real, 1), filled_up(imaginary, 0)} {
  const Eigen::Index n = lower_.real.rows();
  inverses_ = {RowMatrix::Zero(n, kSide), RowMatrix::Zero(n, kSide)};
  Parts times_block = lower_;  // L P^-1: what a block row has before it is multiplied by its column's P
  std::vector<double> right_real(static_cast<std::size_t>(kSide * n)), right_imaginary = right_real;
  double tile_real[kNumbers], tile_imaginary[kNumbers];
  for (Eigen::Index j = 0; j < n; j += kSide) {
    for (Eigen::Index k = 0; k < j; ++k)
      for (Eigen::Index c = 0; c < kSide; ++c) {
        right_real[static_cast<std::size_t>(kSide * k + c)] = times_block.real(j + c, k);
        right_imaginary[static_cast<std::size_t>(kSide * k + c)] = times_block.imaginary(j + c, k);
      }
    for (Eigen::Index i = j; i < n; i += kTileRows) {
      complex_tile({lower_.real.data() + n * i, lower_.imaginary.data() + n * i}, n, 1,
                   {right_real.data(), right_imaginary.data()}, j, tile_real, tile_imaginary);
      for (Eigen::Index r = 0; r < kTileRows; ++r)
        for (Eigen::Index c = 0; c < kSide; ++c) {
          times_block.real(i + r, j + c) -= tile_real[kSide * r + c];
          times_block.imaginary(i + r, j + c) -= tile_imaginary[kSide * r + c];
        }
    }
    double *P = inverses_.real.data() + kSide * j, *Q = inverses_.imaginary.data() + kSide * j;
    for (Eigen::Index r = 0; r < kSide; ++r)
      for (Eigen::Index c = 0; c < kSide; ++c) {
        P[kSide * r + c] = times_block.real(j + std::max(r, c), j + std::min(r, c));
        Q[kSide * r + c] = times_block.imaginary(j + std::max(r, c), j + std::min(r, c));
      }
    invert_block(P, Q);
    for (Eigen::Index i = j + kSide; i < n; i += kTileRows) {
      complex_tile({times_block.real.data() + n * i + j, times_block.imaginary.data() + n * i + j}, n, 1, {P, Q}, kSide,
                   tile_real, tile_imaginary);
      for (Eigen::Index r = 0; r < kTileRows; ++r) {
        std::copy_n(tile_real + kSide * r, kSide, lower_.real.data() + n * (i + r) + j);
        std::copy_n(tile_imaginary + kSide * r, kSide, lower_.imaginary.data() + n * (i + r) + j);
      }
    }
  }
}

Eigen::MatrixXcd ComplexSymmetric::solve(const Eigen::MatrixXcd& b) const {
  const Eigen::Index n = lower_.real.rows();
  Eigen::MatrixXcd out(b.rows(), b.cols());
  double tile_real[kNumbers], tile_imaginary[kNumbers];
  for (Eigen::Index first = 0; first < b.cols(); first += kSide) {
    const Eigen::Index count = std::min(kSide, b.cols() - first);
    RowMatrix x = RowMatrix::Zero(n, kSide), y = x, p(kSide, kSide), q = p;
    x.topLeftCorner(size_, count) = b.middleCols(first, count).real();
    y.topLeftCorner(size_, count) = b.middleCols(first, count).imag();
    const auto subtract_from = [&](Eigen::Index i) {
      for (Eigen::Index e = 0; e < kNumbers; ++e) {
        x.data()[kSide * i + e] -= tile_real[e];
        y.data()[kSide * i + e] -= tile_imaginary[e];
      }
    };
    for (Eigen::Index i = 0; i < n; i += kTileRows) {
      complex_tile({lower_.real.data() + n * i, lower_.imaginary.data() + n * i}, n, 1, {x.data(), y.data()},
                   i / kSide * kSide, tile_real, tile_imaginary);
      subtract_from(i);
    }
    for (Eigen::Index j = n - kSide; j >= 0; j -= kSide) {
      p = x.middleRows(j, kSide);
      q = y.middleRows(j, kSide);
      for (Eigen::Index i = j; i < j + kSide; i += kTileRows) {
        complex_tile({inverses_.real.data() + kSide * i, inverses_.imaginary.data() + kSide * i}, kSide, 1,
                     {p.data(), q.data()}, kSide, tile_real, tile_imaginary);
        std::copy_n(tile_real, kNumbers, x.data() + kSide * i);
        std::copy_n(tile_imaginary, kNumbers, y.data() + kSide * i);
        const Eigen::Index end = j + kSide;
        complex_tile({lower_.real.data() + n * end + i, lower_.imaginary.data() + n * end + i}, 1, n,
                     {x.data() + kSide * end, y.data() + kSide * end}, n - end, tile_real, tile_imaginary);
        subtract_from(i);
      }
    }
    out.middleCols(first, count).real() = x.topLeftCorner(size_, count);
    out.middleCols(first, count).imag() = y.topLeftCorner(size_, count);
  }
  return out;
}

}  // namespace kt
