// Supernodal Cholesky factorization, right-looking: each supernode is a dense block of columns, and what its product
// takes from later ones is subtracted from them at once. All sums are product_tile's: the same bits on every processor.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/wide.hpp"
#include "core/linear/copied_solver.hpp"
#include "core/linear/dense/dense_cholesky.hpp"
#include "core/linear/dense/dense_product.hpp"
#include "core/linear/sparse_product.hpp"
#include "core/linear/sparsity_pattern.hpp"
#include "core/linear/supernodes.hpp"
#include "core/linear/trailing_inverse.hpp"

namespace kt {
namespace {

constexpr int kWide = kGroup;              // columns of a panel
constexpr int kStrip = kGroup / 3;         // nodes whose columns are subtracted at a time
constexpr int kTile = kTileRows * kGroup;  // numbers

std::ptrdiff_t up_to_tiles(std::ptrdiff_t n) { return (n + kTileRows - 1) / kTileRows * kTileRows; }

/// Where a supernode's columns are: rows of `stride` numbers, its own first; some rows of zeros follow, as tiles read
/// on.
struct Place {
  std::ptrdiff_t begin = 0, stride = 0, rows = 0, inverse = 0;
};

/// Of a pattern: the supernodes, and where every number of the matrix goes.
struct BlockAnalysis {
  BlockAnalysis(const SparseMatrix& matrix, const std::vector<int>& last) {
    supernodes = find_supernodes(node_neighbours(matrix), last);
    std::vector<int> place(supernodes.order.size()), of(supernodes.order.size());
    for (std::size_t k = 0; k < place.size(); ++k) place[supernodes.order[k]] = static_cast<int>(k);
    for (std::size_t s = 0; s < supernodes.nodes.size(); ++s) {
      const Supernode& node = supernodes.nodes[s];
      for (int k = 0; k < node.count; ++k) of[node.first + k] = static_cast<int>(s);
      const std::ptrdiff_t own = 3 * node.count, below = 3 * static_cast<std::ptrdiff_t>(node.below.size());
      const std::ptrdiff_t panels = (own + kWide - 1) / kWide;
      places.push_back({size, up_to_tiles(own), own + below, inverse_size});
      size += places.back().stride * (places.back().rows + kTileRows);
      inverse_size += panels * kWide * kWide;
      tallest = std::max(tallest, places.back().rows);
    }
    for (int c = 0; c < matrix.cols() / 3; ++c) {
      const int begin = matrix.outerIndexPtr()[3 * c], height = matrix.outerIndexPtr()[3 * c + 1] - begin;
      for (int k = 0; k < height; k += 3) {
        const int r = matrix.innerIndexPtr()[begin + k] / 3;
        if (r < c) continue;
        const int row = std::max(place[r], place[c]), column = std::min(place[r], place[c]);
        const Supernode& node = supernodes.nodes[of[column]];
        const Place& at = places[of[column]];
        const int end = node.first + node.count;
        const std::ptrdiff_t local =
            row < end ? row - node.first
                      : node.count + (std::lower_bound(node.below.begin(), node.below.end(), row) - node.below.begin());
        entries.push_back({begin + k, height, place[r] < place[c],
                           at.begin + 3 * (at.stride * local + column - node.first), static_cast<int>(at.stride)});
      }
    }
  }
  struct Entry {
    int from, height;  // first number of a block in the matrix, and how far apart its columns are
    bool turned;       // its transpose is in the factor's lower triangle
    std::ptrdiff_t to;
    int stride;
  };
  Supernodes supernodes;
  std::vector<Place> places;
  std::vector<Entry> entries;
  std::ptrdiff_t size = 0, inverse_size = 0, tallest = 0;
};

/// `columns` columns of L's rows, turned: `count` rows of kGroup numbers, the rest zero.
void turn(const double* L, std::ptrdiff_t stride, int columns, std::ptrdiff_t count, double* out) {
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    for (int c = 0; c < columns; ++c) out[kGroup * k + c] = L[stride * c + k];
    for (int c = columns; c < kGroup; ++c) out[kGroup * k + c] = 0;
  }
}

/// Three rows of kGroup numbers for every node are taken from the rows of L that `at` names, `columns` of them.
KT_WIDE void subtract(const double* product, const int* at, const int* end, int columns, double* L,
                      std::ptrdiff_t stride) {
  for (; at < end; ++at, product += 3 * kGroup) {
    double* row = L + 3 * stride * *at;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < columns; ++c) row[stride * r + c] -= product[kGroup * r + c];
  }
}

/// Cholesky factor of `n` <= kWide rows and columns in place, lower triangle, and its inverse, in rows of kWide numbers
/// filled up with zeros.
bool factor_diagonal(double* a, std::ptrdiff_t stride, int n, double* inverse) {
  for (int c = 0; c < n; ++c) {
    for (int k = 0; k < c; ++k) {
      const double x = a[stride * c + k];
      for (int r = c; r < n; ++r) a[stride * r + c] -= a[stride * r + k] * x;
    }
    if (!(a[stride * c + c] > 0)) return false;
    const double root = std::sqrt(a[stride * c + c]), scale = 1 / root;
    a[stride * c + c] = root;
    for (int r = c + 1; r < n; ++r) a[stride * r + c] *= scale;
    for (int r = 0; r < c; ++r) a[stride * r + c] = 0;
  }
  std::fill_n(inverse, kWide * kWide, 0.0);
  for (int r = 0; r < n; ++r) {
    const double scale = 1 / a[stride * r + r];
    for (int k = 0; k < r; ++k)
      for (int c = 0; c <= k; ++c) inverse[kWide * r + c] -= a[stride * r + k] * inverse[kWide * k + c];
    for (int c = 0; c < r; ++c) inverse[kWide * r + c] *= scale;
    inverse[kWide * r + r] = scale;
  }
  return true;
}

class BlockSolver final : public SparseSolver, public CopiedSolver {
 public:
  bool factor(const SparseMatrix& matrix) override {
    const bool changes = pattern_.changes_to(matrix);
    if (changes || (!analysis_ && !others_)) {
      analysis_.reset();
      others_.reset();
      if (has_node_blocks(matrix))
        analysis_ = std::make_shared<const BlockAnalysis>(matrix, last_);
      else
        others_ = make_sparse_solver();
    }
    if (others_) return others_->factor(matrix);
    gather(matrix);
    right_.resize(static_cast<std::size_t>(kGroup * (analysis_->tallest + kTileRows)));
    strip_.resize(static_cast<std::size_t>(kGroup * (analysis_->tallest + kTileRows)));
    for (std::size_t s = 0; s < analysis_->places.size(); ++s) {
      if (!factor_columns(s)) return false;
      subtract_product(s);
    }
    return true;
  }

  MatrixX solve(const MatrixX& rhs) const override {
    if (others_) return others_->solve(rhs);
    RowMatrix out = rhs;
    solve_in_place(out);
    return out;
  }

  /// Loads without numbers on a supernode leave it out on the way down.
  void solve_in_place(RowsRef rhs) const override {
    if (others_) return others_->solve_in_place(rhs);
    thread_local std::vector<double> group, room;  // as large each time
    group.resize(static_cast<std::size_t>(kGroup * rhs.rows()));
    room.resize(static_cast<std::size_t>(kGroup * (analysis_->tallest + kTileRows)));
    const std::vector<int>& order = analysis_->supernodes.order;
    for (Eigen::Index from = 0; from < rhs.cols(); from += kGroup) {
      const Eigen::Index count = std::min<Eigen::Index>(kGroup, rhs.cols() - from);
      const auto row_of = [&](std::size_t k, int c) {
        return rhs.data() + rhs.outerStride() * (3 * order[k] + c) + from;
      };
      for (std::size_t k = 0; k < order.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          double* row = group.data() + kGroup * (3 * k + static_cast<std::size_t>(c));
          std::fill(std::copy_n(row_of(k, c), count, row), row + kGroup, 0.0);
        }
      for (std::size_t s = 0; s < analysis_->places.size(); ++s) forward(s, group.data());
      for (std::size_t s = analysis_->places.size(); s-- > 0;) backward(s, group.data(), room.data());
      for (std::size_t k = 0; k < order.size(); ++k)
        for (int c = 0; c < 3; ++c)
          std::copy_n(group.data() + kGroup * (3 * k + static_cast<std::size_t>(c)), count, row_of(k, c));
    }
  }

  void take_analysis(const SparseSolver& other) override {
    const auto& o = dynamic_cast<const BlockSolver&>(other);
    if (!o.analysis_ && !o.others_) return;
    pattern_ = o.pattern_;
    last_ = o.last_;
    analysis_ = o.analysis_;
    others_.reset();
    if (!o.others_) return;
    others_ = make_sparse_solver();
    others_->take_analysis(*o.others_);
  }

  std::unique_ptr<SparseSolver> copy() const override {
    auto out = std::make_unique<BlockSolver>();
    out->pattern_ = pattern_;
    out->last_ = last_;
    out->analysis_ = analysis_;
    out->values_ = values_;
    out->inverses_ = inverses_;
    if (others_) out->others_ = copy_of(*others_);
    return out;
  }

  void order_last(std::vector<int> nodes) override { last_ = std::move(nodes); }

  /// Of A = L L^T what L has on the last `count` rows and columns, inverted: (L_22 L_22^T)^-1 is what the inverse of A
  /// has there. Nothing where other rows come after some of them.
  struct TrailingFactor {
    RowMatrix inverse;
    std::vector<int> place;  ///< of each of the last rows
  };
  std::optional<TrailingFactor> trailing_factor(Eigen::Index rows, Eigen::Index count) const {
    const int first = static_cast<int>((rows - count) / 3);
    if (others_ || count % 3 != 0 || !ends_with(first)) return {};
    const std::vector<int>& order = analysis_->supernodes.order;
    MatrixX L = MatrixX::Zero(count, count);
    for (std::size_t s = 0; s < analysis_->places.size(); ++s) copy_lower(s, first, L);
    TrailingFactor out{invert_lower(L), std::vector<int>(static_cast<std::size_t>(count))};
    for (std::size_t k = first; k < order.size(); ++k)
      for (int c = 0; c < 3; ++c) out.place[3 * (order[k] - first) + c] = 3 * (static_cast<int>(k) - first) + c;
    return out;
  }

 private:
  /// Whether the nodes from this one on are the last in the order.
  bool ends_with(int first) const {
    const std::vector<int>& order = analysis_->supernodes.order;
    return std::all_of(order.begin() + first, order.end(), [&](int i) { return i >= first; });
  }
  /// The columns of a supernode from place `first` on.
  void copy_lower(std::size_t s, int first, MatrixX& out) const {
    const Place& at = analysis_->places[s];
    const Supernode& node = node_of(s);
    const double* L = values_.data() + at.begin;
    for (int column = std::max(0, first - node.first); column < node.count; ++column) {
      const int to = 3 * (node.first + column - first);
      const auto copy = [&](int row, int at_row) {
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) out(at_row + r, to + c) = L[at.stride * (3 * row + r) + 3 * column + c];
      };
      for (int row = column; row < node.count; ++row) copy(row, 3 * (node.first + row - first));
      for (std::size_t k = 0; k < node.below.size(); ++k)
        copy(node.count + static_cast<int>(k), 3 * (node.below[k] - first));
    }
  }

  const Supernode& node_of(std::size_t s) const { return analysis_->supernodes.nodes[s]; }

  void gather(const SparseMatrix& matrix) {
    values_.assign(static_cast<std::size_t>(analysis_->size), 0.0);
    inverses_.resize(static_cast<std::size_t>(analysis_->inverse_size));
    for (const BlockAnalysis::Entry& e : analysis_->entries) {
      const double* from = matrix.valuePtr() + e.from;
      double* to = values_.data() + e.to;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
          (e.turned ? to[static_cast<std::ptrdiff_t>(e.stride) * c + r]
                    : to[static_cast<std::ptrdiff_t>(e.stride) * r + c]) =
              from[static_cast<std::ptrdiff_t>(e.height) * c + r];
    }
  }

  /// Panel by panel of a supernode's columns, each from those before it.
  bool factor_columns(std::size_t s) {
    const Place& at = analysis_->places[s];
    double* L = values_.data() + at.begin;
    const int own = 3 * node_of(s).count;
    double tile[kTile], turned[kWide * kWide];
    for (int j = 0; j < own; j += kWide) {
      const int wide = std::min(kWide, own - j);
      if (j > 0) {
        turn(L + at.stride * j, at.stride, wide, j, right_.data());
        for (std::ptrdiff_t i = j; i < at.rows; i += kTileRows) {
          product_tile(L + at.stride * i, at.stride, 1, right_.data(), kGroup, j, tile);
          for (int r = 0; r < kTileRows; ++r)
            for (int c = 0; c < wide; ++c) L[at.stride * (i + r) + j + c] -= tile[kGroup * r + c];
        }
      }
      double* inverse = inverses_.data() + at.inverse + kWide * j;
      if (!factor_diagonal(L + at.stride * j + j, at.stride, wide, inverse)) return false;
      turn(inverse, kWide, wide, wide, turned);
      for (std::ptrdiff_t i = j + wide; i < at.rows; i += kTileRows) {
        product_tile(L + at.stride * i + j, at.stride, 1, turned, kGroup, wide, tile);
        for (int r = 0; r < kTileRows; ++r)
          for (int c = 0; c < wide; ++c) L[at.stride * (i + r) + j + c] = tile[kGroup * r + c];
      }
    }
    return true;
  }

  /// From all later supernodes: L L^T of this one's rows below.
  void subtract_product(std::size_t s) {
    const Place& at = analysis_->places[s];
    const Supernode& node = node_of(s);
    const int own = 3 * node.count, below = static_cast<int>(node.below.size());
    const double* L = values_.data() + at.begin + at.stride * own;
    for (const Supernode::Run& run : node.runs) {
      const Place& to = analysis_->places[run.target];
      for (int first = run.from; first < run.to; first += kStrip) {
        const int wide = std::min(kStrip, run.to - first);
        turn(L + 3 * at.stride * first, at.stride, 3 * wide, own, right_.data());
        const std::ptrdiff_t rows = 3 * static_cast<std::ptrdiff_t>(below - first);
        for (std::ptrdiff_t i = 0; i < rows; i += kTileRows)
          product_tile(L + at.stride * (3 * first + i), at.stride, 1, right_.data(), kGroup, own,
                       strip_.data() + kGroup * i);
        const double* product = strip_.data();
        const int *row = run.rows.data() + (first - run.from), *end = run.rows.data() + (below - run.from);
        double* target = values_.data() + to.begin;
        // Columns that are apart in the target go there one node at a time.
        for (int c = 0; c < wide;) {
          int many = 1;
          while (c + many < wide && row[c + many] == row[c] + many) ++many;
          subtract(product + 3 * c, row, end, 3 * many, target + 3 * row[c], to.stride);
          c += many;
        }
      }
    }
  }

  /// L z = x in place, in rows of kGroup numbers.
  void forward(std::size_t s, double* x) const {
    const Place& at = analysis_->places[s];
    const Supernode& node = node_of(s);
    const double* L = values_.data() + at.begin;
    const int own = 3 * node.count;
    double* z = x + kGroup * 3 * node.first;
    if (std::all_of(z, z + kGroup * own, [](double v) { return v == 0; })) return;
    double tile[kTile], sum[kWide * kGroup];
    for (int j = 0; j < own; j += kWide) {
      const int wide = std::min(kWide, own - j);
      for (int i = 0; i < wide; i += kTileRows) {
        product_tile(L + at.stride * (j + i), at.stride, 1, z, kGroup, j, sum + kGroup * i);
        for (int e = 0; e < kTile && i + e / kGroup < wide; ++e)
          sum[kGroup * i + e] = z[kGroup * (j + i) + e] - sum[kGroup * i + e];
      }
      const double* inverse = inverses_.data() + at.inverse + kWide * j;
      for (int i = 0; i < wide; i += kTileRows) {
        product_tile(inverse + kWide * i, kWide, 1, sum, kGroup, wide, tile);
        std::copy_n(tile, kGroup * std::min(kTileRows, wide - i), z + kGroup * (j + i));
      }
    }
    const int below = 3 * static_cast<int>(node.below.size());
    for (int i = 0; i < below; i += kTileRows) {
      product_tile(L + at.stride * (own + i), at.stride, 1, z, kGroup, own, tile);
      for (int r = 0; r < std::min(kTileRows, below - i); ++r) {
        double* to = x + kGroup * (3 * node.below[(i + r) / 3] + (i + r) % 3);
        for (int c = 0; c < kGroup; ++c) to[c] -= tile[kGroup * r + c];
      }
    }
  }

  /// L^T x = z in place. `room`: for one supernode's rows.
  void backward(std::size_t s, double* x, double* room) const {
    const Place& at = analysis_->places[s];
    const Supernode& node = node_of(s);
    const double* L = values_.data() + at.begin;
    const int own = 3 * node.count, rows = own + 3 * static_cast<int>(node.below.size());
    double* z = x + kGroup * 3 * node.first;
    std::copy_n(z, kGroup * own, room);
    for (std::size_t i = 0; i < node.below.size(); ++i)
      std::copy_n(x + kGroup * 3 * node.below[i], 3 * kGroup, room + kGroup * (own + 3 * i));
    double tile[kTile], sum[kWide * kGroup];
    for (int j = (own - 1) / kWide * kWide; j >= 0; j -= kWide) {
      const int wide = std::min(kWide, own - j), end = j + wide;
      for (int i = 0; i < wide; i += kTileRows) {
        product_tile(L + at.stride * end + j + i, 1, at.stride, room + kGroup * end, kGroup, rows - end,
                     sum + kGroup * i);
        for (int e = 0; e < kTile && i + e / kGroup < wide; ++e)
          sum[kGroup * i + e] = room[kGroup * (j + i) + e] - sum[kGroup * i + e];
      }
      const double* inverse = inverses_.data() + at.inverse + kWide * j;
      for (int i = 0; i < wide; i += kTileRows) {
        product_tile(inverse + i, 1, kWide, sum, kGroup, wide, tile);
        std::copy_n(tile, kGroup * std::min(kTileRows, wide - i), room + kGroup * (j + i));
      }
    }
    std::copy_n(room, kGroup * own, z);
  }

  std::shared_ptr<const BlockAnalysis> analysis_;
  std::unique_ptr<SparseSolver> others_;  // for matrices that are not in whole blocks
  SparsityPattern pattern_;               // of either
  std::vector<int> last_;
  std::vector<double> values_, inverses_;  // of the factor; of the diagonal blocks of its panels
  std::vector<double> right_, strip_;      // room
};

}  // namespace

MatrixX trailing_inverse(const SparseSolver& solver, Eigen::Index rows, Eigen::Index count) {
  if (const auto* own = dynamic_cast<const BlockSolver*>(&solver))
    if (const auto found = own->trailing_factor(rows, count))
      return MatrixX(inverse_from(found->inverse)(found->place, found->place));
  MatrixX loads = MatrixX::Zero(rows, count);
  loads.bottomRows(count).setIdentity();
  return solver.solve(loads).bottomRows(count);
}

MatrixX trailing_inverse(const SparseSolver& solver, Eigen::Index rows, const SparseMatrix& P) {
  const Eigen::Index count = P.cols();
  if (const auto* own = dynamic_cast<const BlockSolver*>(&solver))
    if (const auto found = own->trailing_factor(rows, count)) {
      RowMatrix loaded = RowMatrix::Zero(count, P.rows());
      for (Eigen::Index i = 0; i < count; ++i)
        for (Eigen::Index j = 0; j < count; ++j) {
          const double number = found->inverse(i, found->place[j]);
          if (number == 0) continue;
          for (SparseMatrix::InnerIterator it(P, j); it; ++it) loaded(i, it.row()) += it.value() * number;
        }
      return symmetric_product(loaded, loaded);
    }
  MatrixX loads = MatrixX::Zero(rows, P.rows());
  loads.bottomRows(count) = P.transpose();
  return P * solver.solve(loads).bottomRows(count);
}

std::unique_ptr<SparseSolver> make_block_solver() { return std::make_unique<BlockSolver>(); }

}  // namespace kt
