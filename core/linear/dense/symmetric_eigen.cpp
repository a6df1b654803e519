#include "core/linear/dense/symmetric_eigen.hpp"

#include <Eigen/Jacobi>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/wide.hpp"

namespace kt {
namespace {

constexpr Eigen::Index kRows = 32;  // of eigenvectors, filled up to a multiple: four of the widest registers

/// Columns j .. j + 3 of A -= v w^T + w v^T, and product += A x for them; entries from .. n.
KT_WIDE void update_and_multiply(double* __restrict a0, double* __restrict a1, double* __restrict a2,
                                 double* __restrict a3, const double* __restrict v, const double* __restrict w,
                                 const double* vj, const double* wj, const double* xj, double* __restrict product,
                                 Eigen::Index from, Eigen::Index n) {
  for (Eigen::Index i = from; i < n; ++i) {
    const double c0 = a0[i] - v[i] * wj[0] - w[i] * vj[0], c1 = a1[i] - v[i] * wj[1] - w[i] * vj[1];
    const double c2 = a2[i] - v[i] * wj[2] - w[i] * vj[2], c3 = a3[i] - v[i] * wj[3] - w[i] * vj[3];
    a0[i] = c0;
    a1[i] = c1;
    a2[i] = c2;
    a3[i] = c3;
    product[i] += c0 * xj[0] + c1 * xj[1] + c2 * xj[2] + c3 * xj[3];
  }
}

KT_WIDE void update_one(double* __restrict a, const double* __restrict v, const double* __restrict w, double vj,
                        double wj, double xj, double* __restrict product, Eigen::Index from, Eigen::Index n) {
  for (Eigen::Index i = from; i < n; ++i) {
    a[i] = a[i] - v[i] * wj - w[i] * vj;
    product[i] += a[i] * xj;
  }
}

/// sum += v_0 q_0 + .. + v_3 q_3 of four rows; then q_i -= v_i sum.
KT_WIDE void add_rows(const double* __restrict q, Eigen::Index stride, const double* v, double* __restrict sum,
                      Eigen::Index n) {
  for (Eigen::Index i = 0; i < n; ++i)
    sum[i] += v[0] * q[i] + v[1] * q[stride + i] + v[2] * q[2 * stride + i] + v[3] * q[3 * stride + i];
}
KT_WIDE void take_rows(double* __restrict q, Eigen::Index stride, const double* v, const double* __restrict sum,
                       Eigen::Index n) {
  for (Eigen::Index i = 0; i < n; ++i) {
    q[i] -= v[0] * sum[i];
    q[stride + i] -= v[1] * sum[i];
    q[2 * stride + i] -= v[2] * sum[i];
    q[3 * stride + i] -= v[3] * sum[i];
  }
}

/// Rotations of columns k and k + 1, k = 0 .. count - 1, one after the other, of `rows` rows in columns `stride` apart.
/// The column that two rotations share stays in the registers between them.
template <int Width>
KT_INLINE void rotate_in(double* q, Eigen::Index stride, Eigen::Index rows, const double* cosines, const double* sines,
                         Eigen::Index count) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  for (Eigen::Index row = 0; row < rows; row += 4 * Width) {
    Lanes x[4];
    __builtin_memcpy(x, q + row, sizeof x);
    for (Eigen::Index k = 0; k < count; ++k) {
      Lanes y[4], turned[4];
      double* column = q + stride * k + row;
      __builtin_memcpy(y, column + stride, sizeof y);
      const double c = cosines[k], s = sines[k];
      for (int i = 0; i < 4; ++i) {
        turned[i] = c * x[i] - s * y[i];
        x[i] = s * x[i] + c * y[i];
      }
      __builtin_memcpy(column, turned, sizeof turned);
    }
    __builtin_memcpy(q + stride * count + row, x, sizeof x);
  }
}
KT_WIDTHS(rotate,
          (double* q, Eigen::Index stride, Eigen::Index rows, const double* cosines, const double* sines,
           Eigen::Index count),
          (q, stride, rows, cosines, sines, count))

struct Tridiagonal {
  VectorX diagonal, below;
  RowMatrix turn;  // A = turn T turn^T
};

/// Each column loses all below its second entry by a reflection I - scale v v^T from both sides. The change that one
/// reflection makes in the rest of the matrix is made in the pass that multiplies by the next one's vector.
Tridiagonal tridiagonal(MatrixX A) {
  const Eigen::Index n = A.rows(), high = std::max<Eigen::Index>(0, n - 2);
  Tridiagonal out{VectorX(n), VectorX::Zero(std::max<Eigen::Index>(0, n - 1)), RowMatrix::Identity(n, n)};
  MatrixX reflections = MatrixX::Zero(n, high);
  VectorX scales = VectorX::Zero(high), v = VectorX::Zero(n), w = v, x(n), product(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = k; i < n; ++i) A(i, k) = A(i, k) - v[i] * w[k] - w[i] * v[k];
    out.diagonal[k] = A(k, k);
    if (k + 1 < n) out.below[k] = A(k + 1, k);
    if (k >= high) {  // only the last column is left
      if (k + 1 < n) A(n - 1, n - 1) = A(n - 1, n - 1) - 2 * v[n - 1] * w[n - 1];
      if (k + 1 < n) v.setZero(), w.setZero();
      continue;
    }
    double rest_sq = 0;
    for (Eigen::Index i = k + 2; i < n; ++i) rest_sq += A(i, k) * A(i, k);
    double scale = 0;
    x.setZero();
    if (rest_sq > 0) {
      const double first = A(k + 1, k), length = std::sqrt(first * first + rest_sq);
      out.below[k] = first > 0 ? -length : length;
      for (Eigen::Index i = k + 2; i < n; ++i) x[i] = A(i, k);
      x[k + 1] = first - out.below[k];
      scale = 2 / (x[k + 1] * x[k + 1] + rest_sq);
    }
    product.setZero();
    Eigen::Index j = k + 1;
    for (; j + 3 < n; j += 4)
      update_and_multiply(A.col(j).data(), A.col(j + 1).data(), A.col(j + 2).data(), A.col(j + 3).data(), v.data(),
                          w.data(), v.data() + j, w.data() + j, x.data() + j, product.data(), k + 1, n);
    for (; j < n; ++j) update_one(A.col(j).data(), v.data(), w.data(), v[j], w[j], x[j], product.data(), k + 1, n);
    v = x;
    double along = 0;
    for (Eigen::Index i = k + 1; i < n; ++i) along += product[i] * x[i];
    for (Eigen::Index i = k + 1; i < n; ++i) w[i] = scale * (product[i] - 0.5 * scale * along * x[i]);
    w.head(k + 1).setZero();
    reflections.col(k) = x;
    scales[k] = scale;
  }
  VectorX sum(n);
  for (Eigen::Index k = high; k-- > 0;) {
    if (scales[k] == 0) continue;
    const double* vector = reflections.col(k).data();
    const Eigen::Index width = n - k - 1;
    double* first = out.turn.data() + n * (k + 1) + k + 1;
    sum.head(width).setZero();
    Eigen::Index r = 0;
    for (; r + 3 < width; r += 4) add_rows(first + n * r, n, vector + k + 1 + r, sum.data(), width);
    for (Eigen::Index i = r; i < width; ++i)
      for (Eigen::Index c = 0; c < width; ++c) sum[c] += vector[k + 1 + i] * first[n * i + c];
    for (Eigen::Index c = 0; c < width; ++c) sum[c] *= scales[k];
    for (r = 0; r + 3 < width; r += 4) take_rows(first + n * r, n, vector + k + 1 + r, sum.data(), width);
    for (Eigen::Index i = r; i < width; ++i)
      for (Eigen::Index c = 0; c < width; ++c) first[n * i + c] -= vector[k + 1 + i] * sum[c];
  }
  return out;
}

/// Wilkinson's shift for the block that ends at `end`.
double shift(const VectorX& diagonal, const VectorX& below, Eigen::Index end) {
  const double half = 0.5 * (diagonal[end - 1] - diagonal[end]), e = below[end - 1];
  if (half == 0) return diagonal[end] - std::abs(e);
  const double h = std::sqrt(half * half + e * e);
  return diagonal[end] - e / ((half + (half > 0 ? h : -h)) / e);
}

/// One implicit QR step (Golub and Van Loan, algorithm 8.3.2) on start .. end; its rotations.
Eigen::Index qr_step(VectorX& diagonal, VectorX& below, Eigen::Index start, Eigen::Index end, VectorX& cosines,
                     VectorX& sines) {
  double x = diagonal[start] - shift(diagonal, below, end), z = below[start];
  Eigen::Index k = start;
  for (; k < end && z != 0; ++k) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(x, z);
    const double c = rotation.c(), s = rotation.s(), d = diagonal[k], b = below[k];
    const double sdk = s * d + c * b, dkp1 = s * b + c * diagonal[k + 1];
    diagonal[k] = c * (c * d - s * b) - s * (c * b - s * diagonal[k + 1]);
    diagonal[k + 1] = s * sdk + c * dkp1;
    below[k] = c * sdk - s * dkp1;
    if (k > start) below[k - 1] = c * below[k - 1] - s * z;
    x = below[k];
    if (k < end - 1) {
      z = -s * below[k + 1];
      below[k + 1] = c * below[k + 1];
    }
    cosines[k - start] = c;
    sines[k - start] = s;
  }
  return k - start;
}

}  // namespace

SymmetricEigen symmetric_eigen(const MatrixX& A) {
  const Eigen::Index n = A.rows(), rows = (n + kRows - 1) / kRows * kRows;
  if (!A.allFinite()) throw RunError("vibrations: the matrix has entries that are not finite");
  const double largest = n > 0 ? A.cwiseAbs().maxCoeff() : 0, unit = largest > 0 ? largest : 1;
  Tridiagonal t = tridiagonal(A / unit);
  MatrixX Q = MatrixX::Zero(rows, n);
  Q.topRows(n) = t.turn;
  VectorX &diagonal = t.diagonal, &below = t.below, cosines(n), sines(n);
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon(), kLeast = std::numeric_limits<double>::min();
  Eigen::Index end = n - 1;
  for (Eigen::Index steps = 0; end > 0; ++steps) {
    for (Eigen::Index i = 0; i < end; ++i) {
      const double scaled = below[i] / kEpsilon;
      if (std::abs(below[i]) < kLeast || scaled * scaled <= std::abs(diagonal[i]) + std::abs(diagonal[i + 1]))
        below[i] = 0;
    }
    while (end > 0 && below[end - 1] == 0) --end;
    if (end <= 0) break;
    if (steps > 30 * n) throw RunError("vibrations: not found in 30 steps each");
    Eigen::Index start = end - 1;
    while (start > 0 && below[start - 1] != 0) --start;
    const Eigen::Index count = qr_step(diagonal, below, start, end, cosines, sines);
    rotate(Q.data() + rows * start, rows, rows, cosines.data(), sines.data(), count);
  }
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return diagonal[a] < diagonal[b]; });
  return {unit * VectorX(diagonal(order)), Q.topRows(n)(Eigen::all, order)};
}

}  // namespace kt
