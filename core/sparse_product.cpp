#include "core/sparse_product.hpp"

namespace kt {
namespace {

/// Three rows of `to` get a 3 x 3 block (column by column, columns `height` apart) times three rows of `from`.
void add_block(const double* block, int height, const double* from, double* to, Eigen::Index k) {
  const double *c0 = block, *c1 = block + height, *c2 = c1 + height;
  const double *f0 = from, *f1 = from + k, *f2 = f1 + k;
  double *t0 = to, *t1 = to + k, *t2 = t1 + k;
  if (c0[1] == 0 && c0[2] == 0 && c1[0] == 0 && c1[2] == 0 && c2[0] == 0 && c2[1] == 0) {  // of the mass
    for (Eigen::Index i = 0; i < k; ++i) {
      t0[i] += c0[0] * f0[i];
      t1[i] += c1[1] * f1[i];
      t2[i] += c2[2] * f2[i];
    }
    return;
  }
  for (Eigen::Index i = 0; i < k; ++i) {
    t0[i] += c0[0] * f0[i] + c1[0] * f1[i] + c2[0] * f2[i];
    t1[i] += c0[1] * f0[i] + c1[1] * f1[i] + c2[1] * f2[i];
    t2[i] += c0[2] * f0[i] + c1[2] * f1[i] + c2[2] * f2[i];
  }
}

}  // namespace

bool has_node_blocks(const SparseMatrix& A) {
  const int *outer = A.outerIndexPtr(), *inner = A.innerIndexPtr();
  for (int c = 0; c < A.cols(); ++c) {
    const int first = outer[c - c % 3], size = outer[c + 1] - outer[c];
    if (size % 3 != 0 || first + c % 3 * size != outer[c]) return false;
    for (int k = 0; k < size; ++k)
      if (inner[outer[c] + k] != inner[first + k - k % 3] + k % 3 || inner[first + k - k % 3] % 3 != 0) return false;
  }
  return A.cols() % 3 == 0;
}

RowMatrix product(const SparseMatrix& A, const RowMatrix& V) {
  RowMatrix out = RowMatrix::Zero(A.rows(), V.cols());
  if (!has_node_blocks(A)) {
    for (int c = 0; c < A.outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(A, c); it; ++it) out.row(it.row()) += it.value() * V.row(c);
    return out;
  }
  const int *outer = A.outerIndexPtr(), *inner = A.innerIndexPtr();
  for (int c = 0; c < A.cols(); c += 3)
    for (int e = outer[c]; e < outer[c + 1]; e += 3)
      add_block(A.valuePtr() + e, outer[c + 1] - outer[c], V.data() + V.cols() * c, out.data() + V.cols() * inner[e],
                V.cols());
  return out;
}

}  // namespace kt
