#include "core/sparse_product.hpp"

#include "core/wide.hpp"

namespace kt {
namespace {

/// Three rows of a group of A V: the sum of `count` of A's blocks in three columns (`height` numbers each), transposed,
/// times V's rows.
template <int Width>
KT_INLINE void sum_blocks_in(const double* blocks, std::ptrdiff_t height, const int* at, std::ptrdiff_t count,
                             const int* rows, const double* group, double* out) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  for (int column = 0; column < kGroup; column += Width) {
    Lanes s0 = {}, s1 = {}, s2 = {};
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      const std::ptrdiff_t e = at[k];
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
KT_WIDTHS(sum_blocks,
          (const double* blocks, std::ptrdiff_t height, const int* at, std::ptrdiff_t count, const int* rows,
           const double* group, double* out),
          (blocks, height, at, count, rows, group, out))

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

SymmetricMatrix::SymmetricMatrix(const SparseMatrix& A) : A_(A), in_blocks_(has_node_blocks(A)) {
  if (!in_blocks_) return;
  const int* outer = A.outerIndexPtr();
  const double* values = A.valuePtr();
  begin_.reserve(static_cast<std::size_t>(A.cols() / 3 + 1));
  begin_.push_back(0);
  for (int c = 0; c < A.cols(); c += 3) {
    const int height = outer[c + 1] - outer[c];
    for (int e = 0; e < height; e += 3) {
      bool has_numbers = false;
      for (int column = 0; column < 3; ++column)
        for (int r = 0; r < 3; ++r) has_numbers |= values[outer[c + column] + e + r] != 0;
      if (has_numbers) blocks_.push_back(e);
    }
    begin_.push_back(static_cast<int>(blocks_.size()));
  }
}

namespace {

RowMatrix apart(const ColumnGroups& V) {
  RowMatrix out(V.rows, V.cols);
  for (Eigen::Index g = 0; g < V.num_groups(); ++g)
    for (Eigen::Index k = 0; k < V.rows; ++k)
      std::copy_n(V.group(g) + kGroup * k, std::min<Eigen::Index>(kGroup, V.cols - kGroup * g),
                  out.data() + V.cols * k + kGroup * g);
  return out;
}

}  // namespace

ColumnGroups SymmetricMatrix::times(const ColumnGroups& V) const {
  if (!in_blocks_) return ColumnGroups(times(apart(V)));
  const int *outer = A_.outerIndexPtr(), *inner = A_.innerIndexPtr();
  ColumnGroups out(V.rows, V.cols);
  for (Eigen::Index g = 0; g < V.num_groups(); ++g)
    for (Eigen::Index c = 0; c < A_.cols(); c += 3) {
      const int first = begin_[static_cast<std::size_t>(c / 3)], last = begin_[static_cast<std::size_t>(c / 3) + 1];
      sum_blocks(A_.valuePtr() + outer[c], outer[c + 1] - outer[c], blocks_.data() + first, last - first,
                 inner + outer[c], V.group(g), out.group(g) + kGroup * c);
    }
  return out;
}

RowMatrix SymmetricMatrix::times(const RowMatrix& V) const {
  if (in_blocks_) return apart(times(ColumnGroups(V)));
  RowMatrix out = RowMatrix::Zero(A_.rows(), V.cols());
  for (int c = 0; c < A_.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(A_, c); it; ++it) out.row(it.row()) += it.value() * V.row(c);
  return out;
}

}  // namespace kt
