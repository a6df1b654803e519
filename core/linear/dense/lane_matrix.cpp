#include "core/linear/dense/lane_matrix.hpp"

#include "core/base/wide.hpp"

namespace kt {
namespace {

/// A block's columns are read with four numbers, of which the last belongs to the next column: it goes into a lane that
/// is set to zero at the end. One column's products are summed apart from the other two's.
template <int Width>
KT_INLINE void multiply_rows_in(const double* values, const int* neighbours, const int* begin, int first, int last,
                                const double* x, double* out, double* dot) {
  constexpr int kWidth = Width < kLanes ? Width : kLanes, kParts = kLanes / kWidth;
  typedef double Lanes __attribute__((vector_size(8 * kWidth)));  // `using` would lose the size in a template
  Lanes dots[kParts];
  __builtin_memcpy(dots, dot, sizeof dots);
  for (int i = first; i < last; ++i) {
    Lanes sums[3][kParts] = {};
    for (int k = begin[i]; k < begin[i + 1]; ++k) {
      const double* v = x + static_cast<std::ptrdiff_t>(kLanes) * neighbours[k];
      const double* block = values + static_cast<std::ptrdiff_t>(9) * k;
      for (int c = 0; c < 3; ++c)
        for (int p = 0; p < kParts; ++p) {
          Lanes a;
          __builtin_memcpy(&a, block + 3 * c + kWidth * p, sizeof a);
          sums[c][p] += a * v[c];
        }
    }
    double row[kLanes];
    for (int p = 0; p < kParts; ++p) {
      const Lanes y = sums[0][p] + sums[1][p] + sums[2][p];
      __builtin_memcpy(row + kWidth * p, &y, sizeof y);
    }
    row[kLanes - 1] = 0;
    for (int p = 0; p < kParts; ++p) {
      Lanes y, own;
      __builtin_memcpy(&y, row + kWidth * p, sizeof y);
      __builtin_memcpy(&own, x + static_cast<std::ptrdiff_t>(kLanes) * i + kWidth * p, sizeof own);
      __builtin_memcpy(out + static_cast<std::ptrdiff_t>(kLanes) * i + kWidth * p, &y, sizeof y);
      dots[p] += y * own;
    }
  }
  __builtin_memcpy(dot, dots, sizeof dots);
}
KT_WIDTHS(multiply_rows,
          (const double* values, const int* neighbours, const int* begin, int first, int last, const double* x,
           double* out, double* dot),
          (values, neighbours, begin, first, last, x, out, dot))

}  // namespace

void LaneMatrix::set_pattern(const SparseMatrix& matrix, const std::vector<int>& order) {
  order_ = order;
  std::vector<int> place(order.size());
  for (int i = 0; i < num_nodes(); ++i) place[order[i]] = i;
  begin_.assign(1, 0);
  neighbours_.clear();
  diagonal_.assign(order.size(), 0);
  for (int i = 0; i < num_nodes(); ++i) {
    const int j = order[i];
    for (int k = matrix.outerIndexPtr()[3 * j]; k < matrix.outerIndexPtr()[3 * j + 1]; k += 3) {
      const int neighbour = matrix.innerIndexPtr()[k] / 3;
      if (neighbour == j) diagonal_[i] = static_cast<int>(neighbours_.size());
      neighbours_.push_back(place[neighbour]);
    }
    begin_.push_back(static_cast<int>(neighbours_.size()));
  }
  values_.assign(9 * neighbours_.size() + 1, 0);
}

void LaneMatrix::update(const SparseMatrix& matrix) {
  for (int i = 0; i < num_nodes(); ++i) {
    const int j = order_[i], height = 3 * (begin_[i + 1] - begin_[i]);
    // Row i is column i, since the matrix is symmetric: its three columns become one row of three.
    const double* column = matrix.valuePtr() + matrix.outerIndexPtr()[3 * j];
    double* out = values_.data() + static_cast<std::ptrdiff_t>(9) * begin_[i];
    for (int k = 0; k < height; ++k)
      for (int c = 0; c < 3; ++c) out[3 * k + c] = column[height * c + k];
  }
}

void LaneMatrix::times(const double* x, double* out, int first, int last, double* dot) const {
  multiply_rows(values_.data(), neighbours_.data(), begin_.data(), first, last, x, out, dot);
}

Mat3 LaneMatrix::diagonal(int i) const {
  return Mat3::Map(values_.data() + static_cast<std::ptrdiff_t>(9) * diagonal_[i]);
}

void LaneMatrix::to_lanes(const VectorX& stacked, std::vector<double>& out) const {
  out.assign(static_cast<std::size_t>(kLanes) * order_.size(), 0);
  for (int i = 0; i < num_nodes(); ++i)
    Vec3::Map(out.data() + static_cast<std::ptrdiff_t>(kLanes) * i) = node(stacked, order_[i]);
}

void LaneMatrix::from_lanes(const std::vector<double>& lanes, VectorX& out) const {
  out.resize(3 * num_nodes());
  for (int i = 0; i < num_nodes(); ++i)
    node(out, order_[i]) = Vec3::Map(lanes.data() + static_cast<std::ptrdiff_t>(kLanes) * i);
}

}  // namespace kt
