#include "core/fine/fine_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/fine/leaf_stiffness.hpp"

namespace kt {
namespace {

/// dP/dF at the points of leaves.
class LeafModuli {
 public:
  LeafModuli(const FineBody& body, const FineZone& zone, const FineState& state)
      : body_(body), zone_(zone), state_(state), of_cell_(zone.cells.size()) {}

  /// Whether a leaf's cell is strained alike everywhere.
  bool is_even(const FineLeaf& leaf) {
    of(leaf);
    return of_cell_[leaf.cell].is_even;
  }

  const std::array<const Moduli*, kLeafPoints>& of(const FineLeaf& leaf) {
    CellModuli& cell = of_cell_[leaf.cell];
    if (cell.nodes.empty()) start(cell, zone_.cells[leaf.cell]);
    for (int q = 0; q < kLeafPoints; ++q) {
      if (!cell.is_even) moduli_[q] = at(cell, place_in(leaf, q));
      points_[q] = cell.is_even ? &cell.moduli : &moduli_[q];
    }
    return points_;
  }

 private:
  struct CellModuli {
    std::span<const int> nodes;
    Eigen::Matrix<double, 3, 4> gradients;
    bool is_even = false;  // strained alike everywhere
    Moduli moduli;         // then
  };

  void start(CellModuli& cell, int number) {
    cell.nodes = body_.material->cell_nodes(number);
    std::array<Vec3, 4> corners;
    for (int c = 0; c < 4; ++c) corners[c] = node(body_.mesh->x, cell.nodes[c]);
    cell.gradients = share_gradients(corners);
    cell.is_even = cell.nodes.size() == 4;
    if (cell.is_even) cell.moduli = at(cell, Eigen::Vector4d::Constant(0.25));
  }

  Moduli at(const CellModuli& cell, const Eigen::Vector4d& shares) const {
    Mat3 F = Mat3::Zero(), rate = Mat3::Zero();
    const auto add = [&](const auto& gradients) {
      for (Eigen::Index a = 0; a < gradients.cols(); ++a) {
        F += node(state_.coarse.x, cell.nodes[a]) * gradients.col(a).transpose();
        rate += node(state_.coarse.v, cell.nodes[a]) * gradients.col(a).transpose();
      }
    };
    if (cell.nodes.size() == 4)
      add(cell.gradients);
    else
      add(quadratic_gradients(cell.gradients, shares));
    return body_.material->moduli(state_.kind, F, rate);
  }

  /// Shares of the cell's corners at a leaf's point.
  Eigen::Vector4d place_in(const FineLeaf& leaf, int point) const {
    const std::span<const int> corners = of_cell_[leaf.cell].nodes.first(4);
    Eigen::Vector4d out = Eigen::Vector4d::Zero();
    for (int c = 0; c < 4; ++c) {
      const CellPoint& p = zone_.nodes[leaf.node[c]];
      for (int k = 0; k < p.count; ++k)
        out[std::ranges::find(corners, p.corner[k]) - corners.begin()] +=
            (c == point ? kNearShare : kFarShare) * p.share(k);
    }
    return out;
  }

  const FineBody& body_;
  const FineZone& zone_;
  const FineState& state_;
  std::vector<CellModuli> of_cell_;
  std::array<Moduli, kLeafPoints> moduli_;
  std::array<const Moduli*, kLeafPoints> points_{};
};

/// Leaves of a cell that is strained alike everywhere have few shapes (Bey 1995: three, in some positions each); the
/// stiffness of one that is half as large is half.
class LeafShapes {
 public:
  /// @param edges  from its first corner, of the size of the cell itself     @param make  its stiffness at that size
  template <class Make>
  const LeafMatrix& of(int cell, const Mat3& edges, const Make& make) {
    std::vector<Shape>& shapes = of_cell_[cell];
    if (shapes.empty()) shapes.reserve(8);
    const double tolerance = 1e-18 * edges.squaredNorm();
    for (const Shape& s : shapes)  // one that is mirrored at a point is as stiff
      if ((s.edges - edges).squaredNorm() < tolerance || (s.edges + edges).squaredNorm() < tolerance) return s.K;
    return shapes.emplace_back(Shape{edges, make()}).K;
  }

 private:
  struct Shape {
    Mat3 edges;
    LeafMatrix K;
  };
  std::map<int, std::vector<Shape>> of_cell_;
};

/// Unknown nodes that the ten nodes of each leaf follow, ascending.
class Followed {
 public:
  explicit Followed(const FineZone& zone) {
    for (const FineLeaf& leaf : zone.leaves) {
      const auto begin = static_cast<std::ptrdiff_t>(node_.size());
      for (const int a : leaf.node)
        node_.insert(node_.end(), zone.from.begin() + zone.first[a], zone.from.begin() + zone.first[a + 1]);
      std::sort(node_.begin() + begin, node_.end());
      node_.erase(std::unique(node_.begin() + begin, node_.end()), node_.end());
      first_.push_back(node_.size());
    }
  }
  std::size_t num_leaves() const { return first_.size() - 1; }
  std::span<const int> of(std::size_t leaf) const {
    return std::span(node_).subspan(first_[leaf], first_[leaf + 1] - first_[leaf]);
  }

 private:
  std::vector<int> node_;
  std::vector<std::size_t> first_{0};
};

/// Blocks of 3 x 3 numbers for any two unknown nodes that a leaf joins.
class Blocks {
 public:
  Blocks(int num_unknown, const Followed& followed) : local_(static_cast<std::size_t>(num_unknown)) {
    find_rows(num_unknown, followed);
    const Eigen::Index n = 3 * num_unknown;
    matrix_.resize(n, n);
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(9 * rows_.size()));
    std::fill_n(matrix_.valuePtr(), 9 * rows_.size(), 0.0);
    int at = 0;
    for (int j = 0; j < num_unknown; ++j)
      for (int c = 0; c < 3; ++c) {
        matrix_.outerIndexPtr()[3 * j + c] = at;
        for (const int i : rows_of(j))
          for (int r = 0; r < 3; ++r) matrix_.innerIndexPtr()[at++] = 3 * i + r;
      }
    matrix_.outerIndexPtr()[n] = at;
  }

  /// Those of a leaf are added to next.
  void open(std::span<const int> nodes) {
    count_ = nodes.size();
    to_.resize(count_ * count_);
    for (std::size_t j = 0; j < count_; ++j) {
      local_[nodes[j]] = j;
      const int* row = rows_of(nodes[j]).data();
      const int* const first = row;
      for (std::size_t i = 0; i <= j; ++i) {
        while (*row != nodes[i]) ++row;
        to_[j * count_ + i] = first_value(nodes[j]) + 3 * (row - first);
      }
    }
  }

  /// i <= j: the others are their mirrors.
  template <class Block>
  void add(int i, int j, double weight, const Block& block) {
    double* const to = to_[local_[j] * count_ + local_[i]];
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) to[height(j) * c + r] += weight * block(r, c);
  }

  SparseMatrix take() {
    std::vector<std::ptrdiff_t> next(first_.size() - 1, 0);  // row of each column that has not met its mirror
    for (int j = 0; j + 1 < static_cast<int>(first_.size()); ++j)
      for (std::size_t k = 0; k < rows_of(j).size(); ++k) {
        const int i = rows_of(j)[k];
        if (i > j) break;
        if (i == j) next[j] = static_cast<std::ptrdiff_t>(k);
        const double* from = first_value(j) + 3 * static_cast<std::ptrdiff_t>(k);
        double* to = first_value(i) + 3 * next[i]++;
        for (int c = 0; c < 3; ++c)
          for (int r = i == j ? c + 1 : 0; r < 3; ++r) to[height(i) * c + r] = from[height(j) * r + c];
      }
    return std::move(matrix_);
  }

 private:
  void find_rows(int num_unknown, const Followed& followed) {
    std::vector<std::vector<int>> leaves(static_cast<std::size_t>(num_unknown));
    for (std::size_t leaf = 0; leaf < followed.num_leaves(); ++leaf)
      for (const int i : followed.of(leaf)) leaves[i].push_back(static_cast<int>(leaf));
    std::vector<int> seen(static_cast<std::size_t>(num_unknown), -1);
    first_.push_back(0);
    for (int j = 0; j < num_unknown; ++j) {
      for (const int leaf : leaves[j])
        for (const int i : followed.of(leaf))
          if (std::exchange(seen[i], j) != j) rows_.push_back(i);
      std::sort(rows_.begin() + first_.back(), rows_.end());
      first_.push_back(static_cast<std::ptrdiff_t>(rows_.size()));
    }
  }
  std::span<const int> rows_of(int j) const {
    return {rows_.data() + first_[j], static_cast<std::size_t>(first_[j + 1] - first_[j])};
  }
  std::ptrdiff_t height(int j) const { return 3 * (first_[j + 1] - first_[j]); }
  double* first_value(int j) { return matrix_.valuePtr() + matrix_.outerIndexPtr()[3 * j]; }

  std::vector<int> rows_;  // of each column's blocks, ascending
  std::vector<std::ptrdiff_t> first_;
  SparseMatrix matrix_;
  std::size_t count_ = 0;  // nodes of the leaf that is open
  std::vector<std::size_t> local_;
  std::vector<double*> to_;
};

}  // namespace

SparseMatrix fine_stiffness(const FineBody& body, const FineZone& zone, const FineState& state) {
  LeafModuli moduli(body, zone, state);
  LeafShapes shapes;
  const Followed followed(zone);
  Blocks sum(zone.num_unknown(), followed);
  for (std::size_t l = 0; l < zone.leaves.size(); ++l) {
    if (followed.of(l).empty()) continue;  // all of it is held
    const FineLeaf& leaf = zone.leaves[l];
    std::array<Vec3, 4> corners;
    Vec3 middle = Vec3::Zero();
    for (int c = 0; c < 4; ++c) {
      corners[c] = zone.nodes[leaf.node[c]].of(body.mesh->x);
      middle += 0.25 * corners[c];
    }
    const auto add = [&](double factor, const LeafMatrix& K) {
      sum.open(followed.of(l));
      for (int a = 0; a < 10; ++a)
        for (int i = zone.first[leaf.node[a]]; i < zone.first[leaf.node[a] + 1]; ++i)
          for (int b = 0; b < 10; ++b)
            for (int j = zone.first[leaf.node[b]]; j < zone.first[leaf.node[b] + 1]; ++j)
              if (zone.from[i] <= zone.from[j])
                sum.add(zone.from[i], zone.from[j], factor * zone.weight[i] * zone.weight[j],
                        K.block<3, 3>(3 * a, 3 * b));
    };
    const double factor = body.material->stiffness_factor(middle);
    if (!zone.leaf_points.empty() && !zone.leaf_points[l].empty()) {
      add(factor, leaf_stiffness(corners, *moduli.of(leaf)[0], zone.leaf_points[l]));
      continue;
    }
    if (!moduli.is_even(leaf)) {
      add(factor, leaf_stiffness(corners, moduli.of(leaf)));
      continue;
    }
    const double size = std::ldexp(1.0, leaf.level);
    Mat3 edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = size * (corners[c + 1] - corners[0]);
    add(factor / size, shapes.of(leaf.cell, edges, [&] {
      const std::array<Vec3, 4> scaled{Vec3::Zero(), edges.col(0), edges.col(1), edges.col(2)};
      return leaf_stiffness(scaled, moduli.of(leaf));
    }));
  }
  return sum.take();
}

}  // namespace kt
