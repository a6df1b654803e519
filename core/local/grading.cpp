#include "core/local/grading.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {
namespace {

constexpr double kLevel = 0.84;    // radius of a level of ranks to that of the one before, 2^(-1/4)
constexpr double kNearest = 0.01;  // of the way to where weights end: nodes in one place, on two sides of a gap
constexpr double kSupport = 2;     // so many spacings away a kept node is still followed

/// Points in cells of a given size; far apart cells may share a list, so every hit's cell is compared.
class PointCells {
 public:
  PointCells(const VectorX& x, double size)
      : x_(x), size_(size), head_(static_cast<std::size_t>(x.size() / 3) + 1, -1) {
    next_.resize(head_.size());
  }
  void add(int i) {
    int& head = head_[slot(cell(node(x_, i)))];
    next_[i] = head;
    head = i;
  }
  /// Calls visit(i, squared distance) for the points within `radius` of p until it returns true.
  template <class Visit>
  bool find(const Vec3& p, double radius, const Visit& visit) const {
    const Cell low = cell(p - Vec3::Constant(radius)), high = cell(p + Vec3::Constant(radius));
    Cell c;
    for (c[2] = low[2]; c[2] <= high[2]; ++c[2])
      for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
        for (c[0] = low[0]; c[0] <= high[0]; ++c[0])
          for (int i = head_[slot(c)]; i >= 0; i = next_[i]) {
            const double d = (node(x_, i) - p).squaredNorm();
            if (d <= radius * radius && cell(node(x_, i)) == c && visit(i, d)) return true;
          }
    return false;
  }

 private:
  using Cell = std::array<long, 3>;
  Cell cell(const Vec3& p) const {
    Cell out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = std::lround(std::floor(p[static_cast<Eigen::Index>(c)] / size_));
    return out;
  }
  std::size_t slot(const Cell& c) const {
    const auto mixed = static_cast<std::size_t>(c[0]) * 73856093u ^ static_cast<std::size_t>(c[1]) * 19349663u ^
                       static_cast<std::size_t>(c[2]) * 83492791u;
    return mixed % head_.size();
  }
  const VectorX& x_;
  double size_;
  std::vector<int> head_, next_;
};

double square(double x) { return x * x; }

double extent(const VectorX& x) {
  Vec3 low = node(x, 0), high = low;
  for (int i = 1; i < x.size() / 3; ++i) {
    low = low.cwiseMin(node(x, i));
    high = high.cwiseMax(node(x, i));
  }
  return (high - low).norm();
}

struct Neighbour {
  double distance;  // in spacings of the kept node
  int kept;
  bool operator<(const Neighbour& o) const { return distance != o.distance ? distance < o.distance : kept < o.kept; }
};

/// Value at 0 of the affine function that fits best, as weights of the values at `offsets` (in units of their reach).
/// In a plane or on a line the fit is the shortest of all the best ones.
VectorX affine_weights(const Eigen::Matrix<double, Eigen::Dynamic, 4>& basis, const VectorX& importance) {
  const Eigen::Matrix<double, 4, Eigen::Dynamic> weighted = basis.transpose() * importance.asDiagonal();
  const Eigen::Matrix4d gram = weighted * basis;
  const Eigen::LDLT<Eigen::Matrix4d> ldlt(gram);
  Eigen::Vector4d y;
  if (ldlt.vectorD().minCoeff() > 1e-6 * ldlt.vectorD().maxCoeff()) {
    y = ldlt.solve(Eigen::Vector4d::Unit(0));
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(gram);
    y.setZero();
    for (int e = 0; e < 4; ++e)
      if (eigen.eigenvalues()[e] > 1e-6 * eigen.eigenvalues()[3])
        y += eigen.eigenvectors().col(e) * (eigen.eigenvectors()(0, e) / eigen.eigenvalues()[e]);
  }
  return weighted.transpose() * y;
}

/// Weights of `near` (ascending), of which the last only says where the weight has fallen to zero.
VectorX follow(const VectorX& x, int i, const std::vector<Neighbour>& near, std::size_t count, double spacing) {
  const double reach = near[std::min(count, near.size() - 1)].distance * (1 + 1e-4);
  const auto used = static_cast<Eigen::Index>(std::min(count, near.size()));
  Eigen::Matrix<double, Eigen::Dynamic, 4> basis(used, 4);
  VectorX importance(used);
  for (Eigen::Index a = 0; a < used; ++a) {
    const Neighbour& n = near[static_cast<std::size_t>(a)];
    const double q = std::max(n.distance / reach, kNearest);
    basis.row(a) << 1, (node(x, n.kept) - node(x, i)).transpose() / (reach * spacing);
    importance[a] = (1 - q) * (1 - q) / (q * q);  // infinite at the kept node itself: there its motion is taken over
  }
  return affine_weights(basis, importance / importance.maxCoeff());
}

}  // namespace

std::vector<double> node_ranks(const VectorX& x) {
  const int n = static_cast<int>(x.size() / 3);
  std::vector<double> ranks(n, 0);
  std::vector<int> left(n), taken;
  for (int i = 0; i < n; ++i) left[i] = i;
  // Nested nets, widest first. Nodes at one place would never separate: those keep rank 0.
  const double size = extent(x);
  for (double radius = size; !left.empty() && radius > 1e-4 * size; radius *= kLevel) {
    PointCells net(x, radius);
    for (int i : taken) net.add(i);
    std::vector<int> still_left;
    for (int i : left) {
      double nearest_sq = std::min(square(size), 4 * radius * radius);
      net.find(node(x, i), std::sqrt(nearest_sq), [&](int, double distance_sq) {
        nearest_sq = std::min(nearest_sq, distance_sq);
        return nearest_sq < square(radius) * (1 - 1e-9);
      });
      if (nearest_sq < square(radius) * (1 - 1e-9)) {
        still_left.push_back(i);
      } else {
        ranks[i] = std::sqrt(nearest_sq);
        net.add(i);
        taken.push_back(i);
      }
    }
    left = std::move(still_left);
  }
  return ranks;
}

double patch_spacing(const VectorX& x, const std::vector<int>& patch) {
  double sum = 0;
  for (int i : patch) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int k : patch)
      if (k != i) nearest = std::min(nearest, (node(x, i) - node(x, k)).squaredNorm());
    sum += std::sqrt(nearest);
  }
  return sum / static_cast<double>(patch.size());
}

double distance_to(const VectorX& x, const std::vector<int>& patch, int i) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k : patch) nearest = std::min(nearest, (node(x, i) - node(x, k)).squaredNorm());
  return std::sqrt(nearest);
}

std::vector<int> with_nodes_ahead(const VectorX& x, const std::vector<int>& patch, const Vec3& ahead) {
  if (ahead.isZero(0)) return patch;
  std::vector<int> out = patch;
  for (int i : patch) {
    const Vec3 place = node(x, i) + ahead;
    int nearest = i;
    for (int k = 0; k < static_cast<int>(x.size() / 3); ++k)
      if ((node(x, k) - place).squaredNorm() < (node(x, nearest) - place).squaredNorm()) nearest = k;
    out.push_back(nearest);
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

Interpolation interpolate_far_nodes(const VectorX& x, const std::vector<double>& ranks, const std::vector<char>& fixed,
                                    const std::vector<int>& patch, const GradingOptions& options) {
  const int n = static_cast<int>(ranks.size());
  const double edge = patch_spacing(x, patch);
  std::vector<double> spacing(n);
  std::vector<int> support, column_of(n, -1);
  std::vector<char> follows(n, 0);
  Interpolation out;
  for (int i = 0; i < n; ++i) {
    const double distance = distance_to(x, patch, i);
    const double wanted =
        std::min(options.coarsest * edge, options.slope * (distance - options.margin * edge) + 0.5 * edge);
    spacing[i] = std::max(edge, wanted);
    const bool is_near = distance <= options.margin * edge * (1 + 1e-6);
    const bool is_next = distance <= (options.margin - 1) * edge * (1 + 1e-6);
    follows[i] = !is_next && ranks[i] < (is_near ? options.finest * edge : std::max(wanted, options.finest * edge));
    if (follows[i]) continue;
    support.push_back(i);
    if (fixed[i]) continue;
    column_of[i] = static_cast<int>(out.kept.size());
    out.kept.push_back(i);
  }
  PointCells cells(x, 2 * edge);
  for (int i = 0; i < n; ++i)
    if (follows[i] && !fixed[i]) cells.add(i);
  std::vector<std::vector<Neighbour>> near(n);
  for (int a : support)
    cells.find(node(x, a), kSupport * spacing[a], [&](int i, double distance_sq) {
      near[i].push_back({std::sqrt(distance_sq) / spacing[a], a});
      return false;
    });
  out.begin.push_back(0);
  const auto count = static_cast<std::size_t>(options.neighbours);
  for (int i = 0; i < n; ++i) {
    if (fixed[i]) continue;
    if (!follows[i]) {
      out.column.push_back(column_of[i]);
      out.weight.push_back(1);
    } else {
      if (near[i].size() < 5) {  // far from everything: look everywhere
        near[i].clear();
        for (int a : support) near[i].push_back({(node(x, a) - node(x, i)).norm() / spacing[a], a});
      }
      const auto kth = near[i].begin() + static_cast<std::ptrdiff_t>(std::min(count + 1, near[i].size()));
      std::partial_sort(near[i].begin(), kth, near[i].end());
      const VectorX weights = follow(x, i, near[i], count, spacing[i]);
      for (Eigen::Index a = 0; a < weights.size(); ++a)
        if (const int c = column_of[near[i][static_cast<std::size_t>(a)].kept]; c >= 0 && weights[a] != 0) {
          out.column.push_back(c);
          out.weight.push_back(weights[a]);
        }
    }
    out.begin.push_back(static_cast<int>(out.column.size()));
  }
  return out;
}

}  // namespace kt
