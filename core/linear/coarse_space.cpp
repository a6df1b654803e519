#include "core/linear/coarse_space.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.hpp"
#include "core/base/wide.hpp"
#include "core/linear/dense/dense_cholesky.hpp"

namespace kt {
namespace {

// Up to here one product with the coarse matrix's inverse beats two triangular solves of a sparse factor, and needs no
// lock.
constexpr Eigen::Index kDenseLimit = 450;

/// out += A x, four columns at a time.
KT_WIDE void add_columns(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x,
                         double* __restrict out) {
  Eigen::Index c = 0;
  for (; c + 3 < columns; c += 4) {
    const double *a0 = a + rows * c, *a1 = a0 + rows, *a2 = a1 + rows, *a3 = a2 + rows;
    for (Eigen::Index r = 0; r < rows; ++r)
      out[r] += a0[r] * x[c] + a1[r] * x[c + 1] + a2[r] * x[c + 2] + a3[r] * x[c + 3];
  }
  for (; c < columns; ++c)
    for (Eigen::Index r = 0; r < rows; ++r) out[r] += a[rows * c + r] * x[c];
}
void add_columns(const MatrixX& A, const VectorX& x, double* out) {
  add_columns(A.data(), A.rows(), A.cols(), x.data(), out);
}

/// Columns of B [-arm]x: the forces of unit turns.
Mat3 turned(const Mat3& B, const Vec3& arm) {
  Mat3 m;  // turn -> turn x arm
  m << 0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0;
  return B * m;
}

}  // namespace

CoarseSpace::CoarseSpace(const SparseMatrix& matrix, const VectorX& positions) {
  group_nodes(matrix);
  const Eigen::Index groups = static_cast<Eigen::Index>(members_begin_.size()) - 1;
  Eigen::Matrix3Xd centre = Eigen::Matrix3Xd::Zero(3, groups);
  arm_.resize(3, positions.size() / 3);
  for (int g = 0; g < groups; ++g) {
    for (int k = members_begin_[g]; k < members_begin_[g + 1]; ++k)
      centre.col(g) += positions.segment<3>(3 * members_[k]);
    centre.col(g) /= members_begin_[g + 1] - members_begin_[g];
  }
  for (int i = 0; i < arm_.cols(); ++i) arm_.col(i) = positions.segment<3>(3 * i) - centre.col(group_[i]);
  // Turns in units of the groups' size, so that the coarse matrix is well
  // scaled.
  const double size = std::sqrt(arm_.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, arm_.cols())));
  if (size > 0) arm_ /= size;
  make_pattern(matrix);
}

bool CoarseSpace::update(const SparseMatrix& matrix) {
  const int groups = static_cast<int>(members_begin_.size()) - 1;
  std::fill(coarse_.valuePtr(), coarse_.valuePtr() + coarse_.nonZeros(), 0.0);
  parallel_for(groups, [&](int g) {  // its block column
    const int* outer = coarse_.outerIndexPtr() + 6 * g;
    const int height = outer[1] - outer[0];
    for (int k = members_begin_[g]; k < members_begin_[g + 1]; ++k) {
      const int j = members_[k];
      const BlockColumn column(matrix, j);
      const int* slot = slots_.data() + matrix.outerIndexPtr()[3 * j] / 9;
      for (int n = 0; n < column.count; ++n) {
        const Mat3 B = column.block(n);
        Eigen::Matrix<double, 3, 6> right;
        right << B, turned(B, arm_.col(j));
        const Vec3 arm = arm_.col(column.node(n));
        double* out = coarse_.valuePtr() + outer[0] + slot[n];
        for (int c = 0; c < 6; ++c, out += height) {
          const Vec3 f = right.col(c);
          const Vec3 moment = arm.cross(f);
          for (int r = 0; r < 3; ++r) {
            out[r] += f[r];
            out[3 + r] += moment[r];
          }
        }
      }
    }
  });
  if (coarse_.cols() > kDenseLimit) return solver_->factor(coarse_);
  const std::optional<RowMatrix> factor = inverse_factor(MatrixX(coarse_));
  if (factor) inverse_ = inverse_from(*factor);
  return factor.has_value();
}

void CoarseSpace::solve(const VectorX& loads, VectorX& motions) const {
  if (inverse_.size() == 0) {
    motions = solver_->solve(loads);
    return;
  }
  motions.setZero(loads.size());
  add_columns(inverse_, loads, motions.data());
}

/// Seeds more than kReach neighbours apart; every node joins the nearest.
void CoarseSpace::group_nodes(const SparseMatrix& matrix) {
  constexpr int kReach = 3;
  const int n = static_cast<int>(matrix.cols()) / 3;
  group_.assign(static_cast<std::size_t>(n), -1);
  std::vector<int> distance(static_cast<std::size_t>(n), kReach + 1), seeds, queue, next;
  for (int start = 0; start < n; ++start) {
    if (distance[start] <= kReach) continue;
    seeds.push_back(start);
    distance[start] = 0;
    queue.assign(1, start);
    for (std::size_t i = 0; i < queue.size(); ++i) {
      const int at = queue[i];
      if (distance[at] == kReach) continue;
      const BlockColumn column(matrix, at);
      for (int k = 0; k < column.count; ++k)
        if (const int b = column.node(k); distance[b] > distance[at] + 1) {
          distance[b] = distance[at] + 1;
          queue.push_back(b);
        }
    }
  }
  for (std::size_t s = 0; s < seeds.size(); ++s) group_[seeds[s]] = static_cast<int>(s);
  queue = seeds;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const BlockColumn column(matrix, queue[i]);
    for (int k = 0; k < column.count; ++k)
      if (const int b = column.node(k); group_[b] < 0) {
        group_[b] = group_[queue[i]];
        queue.push_back(b);
      }
  }
  // A group of one or two nodes cannot show its turning: it joins a
  // neighbour.
  std::vector<int> size(seeds.size(), 0);
  for (int g : group_) ++size[g];
  for (int i = 0; i < n; ++i) {
    if (size[group_[i]] >= 4) continue;
    const BlockColumn column(matrix, i);
    for (int k = 0; k < column.count; ++k)
      if (const int g = group_[column.node(k)]; size[g] >= 4) {
        --size[group_[i]];
        ++size[group_[i] = g];
        break;
      }
  }
  std::vector<int> number(seeds.size(), -1);
  int groups = 0;
  for (std::size_t g = 0; g < seeds.size(); ++g)
    if (size[g] > 0) number[g] = groups++;
  members_begin_.assign(static_cast<std::size_t>(groups) + 1, 0);
  for (int& g : group_) ++members_begin_[(g = number[g]) + 1];
  for (int g = 0; g < groups; ++g) members_begin_[g + 1] += members_begin_[g];
  members_.resize(static_cast<std::size_t>(n));
  std::vector<int> fill = members_begin_;
  for (int i = 0; i < n; ++i) members_[fill[group_[i]]++] = i;
}

void CoarseSpace::make_pattern(const SparseMatrix& matrix) {
  const int groups = static_cast<int>(members_begin_.size()) - 1;
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(groups));
  for (int j = 0; j < static_cast<int>(group_.size()); ++j) {
    const BlockColumn column(matrix, j);
    for (int k = 0; k < column.count; ++k) rows[group_[j]].push_back(group_[column.node(k)]);
  }
  std::vector<int> outer{0}, inner;
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    for (int c = 0; c < 6; ++c) {
      for (int row : column)
        for (int r = 0; r < 6; ++r) inner.push_back(6 * row + r);
      outer.push_back(static_cast<int>(inner.size()));
    }
  }
  const std::vector<double> zeros(inner.size(), 0.0);
  coarse_ = Eigen::Map<const SparseMatrix>(6 * groups, 6 * groups, static_cast<Eigen::Index>(inner.size()),
                                           outer.data(), inner.data(), zeros.data());
  slots_.clear();
  for (int j = 0; j < static_cast<int>(group_.size()); ++j) {
    const BlockColumn column(matrix, j);
    const auto& present = rows[group_[j]];
    for (int k = 0; k < column.count; ++k)
      slots_.push_back(static_cast<int>(
          6 * (std::lower_bound(present.begin(), present.end(), group_[column.node(k)]) - present.begin())));
  }
}

}  // namespace kt
