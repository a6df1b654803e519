#include "core/sparse_product.hpp"

#include "core/wide.hpp"

namespace kt {
namespace {

/// Three rows of a group of A V: the sum of A's blocks in three columns (`height` numbers each), transposed, times V's
/// rows.
template <int Width>
KT_INLINE void sum_blocks_in(const double* blocks, std::ptrdiff_t height, const int* rows, const double* group,
                             double* out) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  for (int column = 0; column < kGroup; column += Width) {
    Lanes s0 = {}, s1 = {}, s2 = {};
    for (std::ptrdiff_t e = 0; e < height; e += 3) {
      const double *c0 = blocks + e, *c1 = c0 + height, *c2 = c1 + height;
      const double* row = group + kGroup * static_cast<std::ptrdiff_t>(rows[e]) + column;
      Lanes v0, v1, v2;
      __builtin_memcpy(&v0, row, sizeof v0);
      __builtin_memcpy(&v1, row + kGroup, sizeof v1);
      __builtin_memcpy(&v2, row + 2 * kGroup, sizeof v2);
      s0 += c0[0] * v0 + c0[1] * v1 + c0[2] * v2;
      s1 += c1[0] * v0 + c1[1] * v1 + c1[2] * v2;
      s2 += c2[0] * v0 + c2[1] * v1 + c2[2] * v2;
    }
    __builtin_memcpy(out + column, &s0, sizeof s0);
    __builtin_memcpy(out + kGroup + column, &s1, sizeof s1);
    __builtin_memcpy(out + 2 * kGroup + column, &s2, sizeof s2);
  }
}
KT_WIDTHS(sum_blocks, (const double* blocks, std::ptrdiff_t height, const int* rows, const double* group, double* out),
          (blocks, height, rows, group, out))

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

RowMatrix symmetric_times(const SparseMatrix& A, const RowMatrix& V) {
  const int *outer = A.outerIndexPtr(), *inner = A.innerIndexPtr();
  if (!has_node_blocks(A)) {
    RowMatrix out = RowMatrix::Zero(A.rows(), V.cols());
    for (int c = 0; c < A.outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(A, c); it; ++it) out.row(it.row()) += it.value() * V.row(c);
    return out;
  }
  RowMatrix out(A.rows(), V.cols());
  thread_local std::vector<double> groups;  // as large each time
  in_groups(V, groups);
  double rows[3 * kGroup];
  for (Eigen::Index g = 0; kGroup * g < V.cols(); ++g)
    for (Eigen::Index c = 0; c < A.cols(); c += 3) {
      sum_blocks(A.valuePtr() + outer[c], outer[c + 1] - outer[c], inner + outer[c],
                 groups.data() + kGroup * V.rows() * g, rows);
      for (int i = 0; i < 3; ++i)
        std::copy_n(rows + kGroup * i, std::min<Eigen::Index>(kGroup, V.cols() - kGroup * g),
                    out.data() + V.cols() * (c + i) + kGroup * g);
    }
  return out;
}

}  // namespace kt
