#include "core/linear/sparse_product.hpp"

#include "core/base/parallel.hpp"
#include "core/base/wide.hpp"

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

namespace {

/// Rows of matrix x for the nodes begin .. end, by columns since the matrix is
/// symmetric. Each is summed in eight parts at every vector width. `gathered`:
/// room for the nodes of a column.
template <int Width>
KT_INLINE void multiply_columns_in(const SparseMatrix& matrix, const double* x, double* out, int begin, int end,
                                   double* gathered) {
  typedef double Lanes __attribute__((vector_size(8 * Width)));  // `using` would lose the size in a template
  constexpr int kParts = 8 / Width;
  const int *outer = matrix.outerIndexPtr(), *inner = matrix.innerIndexPtr();
  for (int j = begin; j < end; ++j) {
    const int first = outer[3 * j], height = outer[3 * j + 1] - first;
    for (int k = 0; k < height; k += 3) {
      const double* v = x + inner[first + k];
      gathered[k] = v[0];
      gathered[k + 1] = v[1];
      gathered[k + 2] = v[2];
    }
    const double* column = matrix.valuePtr() + first;
    Lanes sums[3][kParts] = {};
    int k = 0;
    for (; k + 8 <= height; k += 8)
      for (int p = 0; p < kParts; ++p) {
        Lanes v;
        __builtin_memcpy(&v, gathered + k + Width * p, sizeof v);
        for (int c = 0; c < 3; ++c) {
          Lanes a;
          __builtin_memcpy(&a, column + static_cast<std::ptrdiff_t>(c) * height + k + Width * p, sizeof a);
          sums[c][p] += a * v;
        }
      }
    for (int c = 0; c < 3; ++c) {
      double part[8];
      __builtin_memcpy(part, sums[c], sizeof part);
      for (int rest = k; rest < height; ++rest)
        part[rest - k] += column[static_cast<std::ptrdiff_t>(c) * height + rest] * gathered[rest];
      out[3 * j + c] = ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
    }
  }
}
KT_WIDTHS(multiply_columns,
          (const SparseMatrix& matrix, const double* x, double* out, int begin, int end, double* gathered),
          (matrix, x, out, begin, end, gathered))

}  // namespace

VectorX symmetric_blocks_times(const SparseMatrix& A, const VectorX& x) {
  VectorX out(A.cols());
  const int nodes = static_cast<int>(A.cols()) / 3;
  constexpr int kChunk = 2048;  // nodes a task
  parallel_for((nodes + kChunk - 1) / kChunk, [&](int i) {
    const int begin = i * kChunk, end = std::min(nodes, begin + kChunk);
    int tallest = 0;
    for (int j = begin; j < end; ++j)
      tallest = std::max(tallest, A.outerIndexPtr()[3 * j + 1] - A.outerIndexPtr()[3 * j]);
    thread_local std::vector<double> gathered;
    gathered.resize(static_cast<std::size_t>(tallest));
    multiply_columns(A, x.data(), out.data(), begin, end, gathered.data());
  });
  return out;
}

}  // namespace kt
