// Conjugate gradients from the last solution. The preconditioner adds two
// levels: the inverse of every node's own 3 x 3 block, for what changes from
// node to node; and a coarse problem in which groups of nodes move as rigid
// bodies, for what spreads far (Nicolaides 1987; rigid groups as in smoothed
// aggregation, Vanek, Mandel and Brezina 1996). The coarse matrix of an earlier
// step serves until the iterations show that it has aged.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/dense_cholesky.hpp"
#include "core/parallel.hpp"
#include "core/sparse_solver.hpp"
#include "core/sparsity_pattern.hpp"
#include "core/step_solver.hpp"
#include "core/wide.hpp"

namespace kt {
namespace {

// Up to here one product with the coarse matrix's inverse beats two triangular
// solves of a sparse factor, and needs no lock.
constexpr Eigen::Index kDenseLimit = 450;
constexpr int kChunk = 512; // nodes a task; sums are made chunk by chunk, the
                            // same for any number of threads

template <class Work> void for_each_chunk(int nodes, const Work &work) {
  parallel_for((nodes + kChunk - 1) / kChunk, [&](int i) {
    work(i, i * kChunk, std::min(nodes, (i + 1) * kChunk));
  });
}

/// Column of node blocks j of a matrix in whole node blocks: rows of nodes and
/// values.
struct BlockColumn {
  BlockColumn(const SparseMatrix &m, int j) {
    const int *outer = m.outerIndexPtr() + 3 * j;
    rows = m.innerIndexPtr() + outer[0];
    count = (outer[1] - outer[0]) / 3;
    for (int c = 0; c < 3; ++c)
      column[c] = m.valuePtr() + outer[c];
  }
  int node(int k) const { return rows[3 * k] / 3; }
  Mat3 block(int k) const {
    Mat3 out;
    for (int c = 0; c < 3; ++c)
      out.col(c) = Vec3::Map(column[c] + 3 * k);
    return out;
  }
  const int *rows;
  const double *column[3];
  int count;
};

/// Rows of matrix x for the nodes begin .. end, by columns since the matrix is
/// symmetric. Each is summed in eight parts at every vector width. `gathered`:
/// room for the nodes of a column.
template <int Width>
KT_INLINE void multiply_columns_in(const SparseMatrix &matrix, const double *x,
                                   double *out, int begin, int end,
                                   double *gathered) {
  typedef double Lanes __attribute__((
      vector_size(8 * Width))); // `using` would lose the size in a template
  constexpr int kParts = 8 / Width;
  const int *outer = matrix.outerIndexPtr(), *inner = matrix.innerIndexPtr();
  for (int j = begin; j < end; ++j) {
    const int first = outer[3 * j], height = outer[3 * j + 1] - first;
    for (int k = 0; k < height; k += 3) {
      const double *v = x + inner[first + k];
      gathered[k] = v[0];
      gathered[k + 1] = v[1];
      gathered[k + 2] = v[2];
    }
    const double *column = matrix.valuePtr() + first;
    Lanes sums[3][kParts] = {};
    int k = 0;
    for (; k + 8 <= height; k += 8)
      for (int p = 0; p < kParts; ++p) {
        Lanes v;
        __builtin_memcpy(&v, gathered + k + Width * p, sizeof v);
        for (int c = 0; c < 3; ++c) {
          Lanes a;
          __builtin_memcpy(&a,
                           column + static_cast<std::ptrdiff_t>(c) * height +
                               k + Width * p,
                           sizeof a);
          sums[c][p] += a * v;
        }
      }
    for (int c = 0; c < 3; ++c) {
      double part[8];
      __builtin_memcpy(part, sums[c], sizeof part);
      for (int rest = k; rest < height; ++rest)
        part[rest - k] +=
            column[static_cast<std::ptrdiff_t>(c) * height + rest] *
            gathered[rest];
      out[3 * j + c] = ((part[0] + part[1]) + (part[2] + part[3])) +
                       ((part[4] + part[5]) + (part[6] + part[7]));
    }
  }
}
KT_WIDTHS(multiply_columns,
          (const SparseMatrix &matrix, const double *x, double *out, int begin,
           int end, double *gathered),
          (matrix, x, out, begin, end, gathered))

/// out = matrix x; returns x . out.
double multiply(const SparseMatrix &matrix, const VectorX &x, VectorX &out,
                std::vector<double> &partial) {
  const int nodes = static_cast<int>(matrix.cols()) / 3;
  for_each_chunk(nodes, [&](int chunk, int begin, int end) {
    int tallest = 0;
    for (int j = begin; j < end; ++j)
      tallest = std::max(tallest, matrix.outerIndexPtr()[3 * j + 1] -
                                      matrix.outerIndexPtr()[3 * j]);
    thread_local std::vector<double> gathered;
    gathered.resize(static_cast<std::size_t>(tallest));
    multiply_columns(matrix, x.data(), out.data(), begin, end, gathered.data());
    double dot = 0;
    for (int k = 3 * begin; k < 3 * end; ++k)
      dot += x[k] * out[k];
    partial[chunk] = dot;
  });
  double sum = 0;
  for (double p : partial)
    sum += p;
  return sum;
}

/// out += A x, four columns at a time.
KT_WIDE void add_columns(const double *a, Eigen::Index rows,
                         Eigen::Index columns, const double *x,
                         double *__restrict out) {
  Eigen::Index c = 0;
  for (; c + 3 < columns; c += 4) {
    const double *a0 = a + rows * c, *a1 = a0 + rows, *a2 = a1 + rows,
                 *a3 = a2 + rows;
    for (Eigen::Index r = 0; r < rows; ++r)
      out[r] +=
          a0[r] * x[c] + a1[r] * x[c + 1] + a2[r] * x[c + 2] + a3[r] * x[c + 3];
  }
  for (; c < columns; ++c)
    for (Eigen::Index r = 0; r < rows; ++r)
      out[r] += a[rows * c + r] * x[c];
}
void add_columns(const MatrixX &A, const VectorX &x, double *out) {
  add_columns(A.data(), A.rows(), A.cols(), x.data(), out);
}

/// Groups of neighbouring nodes and their motion as rigid bodies.
class CoarseSpace {
public:
  CoarseSpace(const SparseMatrix &matrix, const VectorX &positions) {
    group_nodes(matrix);
    const Eigen::Index groups =
        static_cast<Eigen::Index>(members_begin_.size()) - 1;
    centre_.setZero(3, groups);
    arm_.resize(3, positions.size() / 3);
    for (int g = 0; g < groups; ++g) {
      for (int k = members_begin_[g]; k < members_begin_[g + 1]; ++k)
        centre_.col(g) += positions.segment<3>(3 * members_[k]);
      centre_.col(g) /= members_begin_[g + 1] - members_begin_[g];
    }
    for (int i = 0; i < arm_.cols(); ++i)
      arm_.col(i) = positions.segment<3>(3 * i) - centre_.col(group_[i]);
    // Turns in units of the groups' size, so that the coarse matrix is well
    // scaled.
    const double size =
        std::sqrt(arm_.squaredNorm() /
                  static_cast<double>(std::max<Eigen::Index>(1, arm_.cols())));
    if (size > 0)
      arm_ /= size;
    make_pattern(matrix);
  }

  /// Factors P^T matrix P. False when it is not positive definite.
  bool update(const SparseMatrix &matrix) {
    const int groups = static_cast<int>(members_begin_.size()) - 1;
    std::fill(coarse_.valuePtr(), coarse_.valuePtr() + coarse_.nonZeros(), 0.0);
    parallel_for(groups, [&](int g) { // its block column
      const int *outer = coarse_.outerIndexPtr() + 6 * g;
      const int height = outer[1] - outer[0];
      for (int k = members_begin_[g]; k < members_begin_[g + 1]; ++k) {
        const int j = members_[k];
        const BlockColumn column(matrix, j);
        const int *slot = slots_.data() + matrix.outerIndexPtr()[3 * j] / 9;
        for (int n = 0; n < column.count; ++n) {
          const Mat3 B = column.block(n);
          Eigen::Matrix<double, 3, 6> right;
          right << B, turned(B, arm_.col(j));
          const Vec3 arm = arm_.col(column.node(n));
          double *out = coarse_.valuePtr() + outer[0] + slot[n];
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
    if (coarse_.cols() > kDenseLimit)
      return solver_->factor(coarse_);
    const std::optional<RowMatrix> factor = inverse_factor(MatrixX(coarse_));
    if (factor)
      inverse_ = inverse_from(*factor);
    return factor.has_value();
  }

  /// z += P (P^T A P)^-1 P^T r.
  void correct(const VectorX &r, VectorX &z) const {
    const int groups = static_cast<int>(members_begin_.size()) - 1;
    VectorX loads(6 * groups);
    parallel_for((groups + 15) / 16, [&](int chunk) {
      for (int g = 16 * chunk; g < std::min(groups, 16 * chunk + 16); ++g) {
        Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
        for (int k = members_begin_[g]; k < members_begin_[g + 1]; ++k) {
          const Vec3 f = r.segment<3>(3 * members_[k]);
          force += f;
          moment += Vec3(arm_.col(members_[k])).cross(f);
        }
        loads.segment<6>(6 * g) << force, moment;
      }
    });
    VectorX motion = VectorX::Zero(inverse_.cols());
    if (inverse_.size() > 0)
      add_columns(inverse_, loads, motion.data());
    else
      motion = solver_->solve(loads);
    for_each_chunk(static_cast<int>(group_.size()),
                   [&](int, int begin, int end) {
                     for (int i = begin; i < end; ++i) {
                       const Vec3 turn = motion.segment<3>(6 * group_[i] + 3);
                       z.segment<3>(3 * i) += motion.segment<3>(6 * group_[i]) +
                                              turn.cross(Vec3(arm_.col(i)));
                     }
                   });
  }

private:
  /// Columns of B [-arm]x: the forces of unit turns.
  static Mat3 turned(const Mat3 &B, const Vec3 &arm) {
    Mat3 m; // turn -> turn x arm
    m << 0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0;
    return B * m;
  }

  /// Seeds more than kReach neighbours apart; every node joins the nearest.
  void group_nodes(const SparseMatrix &matrix) {
    constexpr int kReach = 3;
    const int n = static_cast<int>(matrix.cols()) / 3;
    group_.assign(static_cast<std::size_t>(n), -1);
    std::vector<int> distance(static_cast<std::size_t>(n), kReach + 1), seeds,
        queue, next;
    for (int start = 0; start < n; ++start) {
      if (distance[start] <= kReach)
        continue;
      seeds.push_back(start);
      distance[start] = 0;
      queue.assign(1, start);
      for (std::size_t i = 0; i < queue.size(); ++i) {
        const int at = queue[i];
        if (distance[at] == kReach)
          continue;
        const BlockColumn column(matrix, at);
        for (int k = 0; k < column.count; ++k)
          if (const int b = column.node(k); distance[b] > distance[at] + 1) {
            distance[b] = distance[at] + 1;
            queue.push_back(b);
          }
      }
    }
    for (std::size_t s = 0; s < seeds.size(); ++s)
      group_[seeds[s]] = static_cast<int>(s);
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
    for (int g : group_)
      ++size[g];
    for (int i = 0; i < n; ++i) {
      if (size[group_[i]] >= 4)
        continue;
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
      if (size[g] > 0)
        number[g] = groups++;
    members_begin_.assign(static_cast<std::size_t>(groups) + 1, 0);
    for (int &g : group_)
      ++members_begin_[(g = number[g]) + 1];
    for (int g = 0; g < groups; ++g)
      members_begin_[g + 1] += members_begin_[g];
    members_.resize(static_cast<std::size_t>(n));
    std::vector<int> fill = members_begin_;
    for (int i = 0; i < n; ++i)
      members_[fill[group_[i]]++] = i;
  }

  void make_pattern(const SparseMatrix &matrix) {
    const int groups = static_cast<int>(members_begin_.size()) - 1;
    std::vector<std::vector<int>> rows(static_cast<std::size_t>(groups));
    for (int j = 0; j < static_cast<int>(group_.size()); ++j) {
      const BlockColumn column(matrix, j);
      for (int k = 0; k < column.count; ++k)
        rows[group_[j]].push_back(group_[column.node(k)]);
    }
    std::vector<int> outer{0}, inner;
    for (auto &column : rows) {
      std::sort(column.begin(), column.end());
      column.erase(std::unique(column.begin(), column.end()), column.end());
      for (int c = 0; c < 6; ++c) {
        for (int row : column)
          for (int r = 0; r < 6; ++r)
            inner.push_back(6 * row + r);
        outer.push_back(static_cast<int>(inner.size()));
      }
    }
    const std::vector<double> zeros(inner.size(), 0.0);
    coarse_ = Eigen::Map<const SparseMatrix>(
        6 * groups, 6 * groups, static_cast<Eigen::Index>(inner.size()),
        outer.data(), inner.data(), zeros.data());
    slots_.clear();
    for (int j = 0; j < static_cast<int>(group_.size()); ++j) {
      const BlockColumn column(matrix, j);
      const auto &present = rows[group_[j]];
      for (int k = 0; k < column.count; ++k)
        slots_.push_back(static_cast<int>(
            6 * (std::lower_bound(present.begin(), present.end(),
                                  group_[column.node(k)]) -
                 present.begin())));
    }
  }

  std::vector<int> group_;                   // of each node
  std::vector<int> members_, members_begin_; // nodes of each group
  Eigen::Matrix3Xd centre_, arm_; // of the groups; of the nodes about them
  SparseMatrix coarse_;
  std::vector<int>
      slots_; // of each node block: first row in its group's column
  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
  MatrixX inverse_; // of the coarse matrix, when it is small
};

class ConjugateGradients final : public StepSolver {
public:
  explicit ConjugateGradients(StepSolverOptions options)
      : options_(std::move(options)) {}

  bool solve(const SparseMatrix &matrix, const VectorX &rhs,
             VectorX &x) override {
    if (!prepare(matrix) || !iterate(matrix, rhs, x, options_.tolerance))
      return false;
    if (fresh_iterations_ == 0)
      fresh_iterations_ = std::max(1, iterations_);
    aged_ = iterations_ > fresh_iterations_ + fresh_iterations_ / 4 + 2;
    return true;
  }
  /// How the coarse matrix ages shows in solutions of one accuracy: not in
  /// these.
  bool solve_roughly(const SparseMatrix &matrix, const VectorX &rhs,
                     VectorX &x) override {
    return prepare(matrix) &&
           iterate(matrix, rhs, x, std::max(kRough, options_.tolerance));
  }
  int iterations() const override { return iterations_; }

private:
  static constexpr double kRough = 1e-3;

  bool prepare(const SparseMatrix &matrix) {
    const bool is_new = pattern_.changes_to(matrix);
    if (is_new)
      coarse_ = std::make_unique<CoarseSpace>(matrix, options_.positions);
    if (!invert_blocks(matrix))
      return false;
    if (is_new || aged_) {
      if (!coarse_->update(matrix))
        return false;
      fresh_iterations_ = 0;
      aged_ = false;
    }
    return true;
  }

  bool invert_blocks(const SparseMatrix &matrix) {
    const int nodes = static_cast<int>(matrix.cols()) / 3;
    inverse_.resize(3, 3 * nodes);
    partial_.assign(static_cast<std::size_t>((nodes + kChunk - 1) / kChunk),
                    0.0);
    for_each_chunk(nodes, [&](int chunk, int begin, int end) {
      bool definite = true;
      for (int j = begin; j < end; ++j) {
        const BlockColumn column(matrix, j);
        int k = 0;
        while (column.node(k) != j)
          ++k;
        const Mat3 block = column.block(k);
        definite &= block(0, 0) > 0 &&
                    block.topLeftCorner<2, 2>().determinant() > 0 &&
                    block.determinant() > 0;
        inverse_.middleCols<3>(3 * j) = block.inverse();
      }
      partial_[chunk] = definite ? 0 : 1;
    });
    return std::all_of(partial_.begin(), partial_.end(),
                       [](double p) { return p == 0; });
  }

  /// z = preconditioner r; returns r . z.
  double precondition(const VectorX &r, VectorX &z) {
    for_each_chunk(static_cast<int>(r.size()) / 3,
                   [&](int, int begin, int end) {
                     for (int j = begin; j < end; ++j)
                       z.segment<3>(3 * j) =
                           inverse_.middleCols<3>(3 * j) * r.segment<3>(3 * j);
                   });
    coarse_->correct(r, z);
    return r.dot(z);
  }

  /// False: not positive definite, or not converging.
  bool iterate(const SparseMatrix &matrix, const VectorX &rhs, VectorX &x,
               double tolerance) {
    const double enough = tolerance * rhs.norm();
    VectorX r(rhs.size()), z(rhs.size()), p(rhs.size()), q(rhs.size());
    if (x.size() != rhs.size())
      x.setZero(rhs.size());
    multiply(matrix, x, q, partial_);
    r = rhs - q;
    iterations_ = 0;
    if (r.norm() <= enough)
      return true;
    double rz = precondition(r, z);
    p = z;
    for (iterations_ = 1; iterations_ <= options_.most_iterations;
         ++iterations_) {
      const double curvature = multiply(matrix, p, q, partial_);
      if (!(curvature > 0) || !(rz > 0))
        return false;
      const double step = rz / curvature;
      x += step * p;
      r -= step * q;
      if (r.norm() <= enough)
        return true;
      const double rz_before = rz;
      rz = precondition(r, z);
      p = z + (rz / rz_before) * p;
    }
    return false;
  }

  StepSolverOptions options_;
  SparsityPattern pattern_;
  std::unique_ptr<CoarseSpace> coarse_;
  Eigen::Matrix3Xd inverse_; // of each node's block
  std::vector<double> partial_;
  int iterations_ = 0;
  int fresh_iterations_ = 0; // with the coarse matrix of the same step
  bool aged_ = false;
};

} // namespace

std::unique_ptr<StepSolver> make_pcg_step_solver(StepSolverOptions options) {
  return std::make_unique<ConjugateGradients>(std::move(options));
}

} // namespace kt
