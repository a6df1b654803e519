#include "core/fine/fine_stiffness.hpp"

#include <cmath>
#include <map>

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

/// Unknown nodes that a leaf's ten nodes follow, and blocks of three columns for every node.
class Pattern {
 public:
  explicit Pattern(const FineZone& zone) : rows_(static_cast<std::size_t>(zone.num_unknown())) {
    for (const FineLeaf& leaf : zone.leaves) {
      const std::vector<int> nodes = followed(zone, leaf);
      for (const int j : nodes) rows_[j].insert(rows_[j].end(), nodes.begin(), nodes.end());
    }
    std::vector<int> outer{0}, inner;
    for (auto& rows : rows_) {
      std::ranges::sort(rows);
      rows.erase(std::ranges::unique(rows).begin(), rows.end());
      for (int c = 0; c < 3; ++c) {
        for (const int i : rows) inner.insert(inner.end(), {3 * i, 3 * i + 1, 3 * i + 2});
        outer.push_back(static_cast<int>(inner.size()));
      }
    }
    const Eigen::Index n = 3 * zone.num_unknown();
    const std::vector<double> zeros(inner.size(), 0.0);
    matrix_ = Eigen::Map<const SparseMatrix>(n, n, static_cast<Eigen::Index>(inner.size()), outer.data(), inner.data(),
                                             zeros.data());
  }

  /// i <= j: the others are their mirrors.
  template <class Block>
  void add(int i, int j, double weight, const Block& block) {
    double* to = values_of(i, j);
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) to[height(j) * c + r] += weight * block(r, c);
  }

  SparseMatrix take() {
    for (int j = 0; j < static_cast<int>(rows_.size()); ++j)
      for (const int i : rows_[j]) {
        if (i > j) break;
        const double* from = values_of(i, j);
        double* to = values_of(j, i);
        for (int c = 0; c < 3; ++c)
          for (int r = i == j ? c + 1 : 0; r < 3; ++r) to[height(i) * c + r] = from[height(j) * r + c];
      }
    return std::move(matrix_);
  }

 private:
  static std::vector<int> followed(const FineZone& zone, const FineLeaf& leaf) {
    std::vector<int> out;
    for (const int a : leaf.node)
      out.insert(out.end(), zone.from.begin() + zone.first[a], zone.from.begin() + zone.first[a + 1]);
    std::ranges::sort(out);
    out.erase(std::ranges::unique(out).begin(), out.end());
    return out;
  }
  std::ptrdiff_t height(int j) const { return 3 * static_cast<std::ptrdiff_t>(rows_[j].size()); }
  /// First number of a block in its first column.
  double* values_of(int i, int j) {
    return matrix_.valuePtr() + matrix_.outerIndexPtr()[3 * j] +
           3 * (std::ranges::lower_bound(rows_[j], i) - rows_[j].begin());
  }
  std::vector<std::vector<int>> rows_;
  SparseMatrix matrix_;
};

}  // namespace

SparseMatrix fine_stiffness(const FineBody& body, const FineZone& zone, const FineState& state) {
  LeafModuli moduli(body, zone, state);
  LeafShapes shapes;
  Pattern sum(zone);
  for (const FineLeaf& leaf : zone.leaves) {
    std::array<Vec3, 4> corners;
    Vec3 middle = Vec3::Zero();
    for (int c = 0; c < 4; ++c) {
      corners[c] = zone.nodes[leaf.node[c]].of(body.mesh->x);
      middle += 0.25 * corners[c];
    }
    LeafMatrix K;
    if (moduli.is_even(leaf)) {
      const double size = std::ldexp(1.0, leaf.level);
      Mat3 edges;
      for (int c = 0; c < 3; ++c) edges.col(c) = size * (corners[c + 1] - corners[0]);
      K = shapes.of(leaf.cell, edges, [&] {
        const std::array<Vec3, 4> scaled{Vec3::Zero(), edges.col(0), edges.col(1), edges.col(2)};
        return leaf_stiffness(scaled, moduli.of(leaf));
      });
      K *= body.material->stiffness_factor(middle) / size;
    } else {
      K = body.material->stiffness_factor(middle) * leaf_stiffness(corners, moduli.of(leaf));
    }
    for (int a = 0; a < 10; ++a)
      for (int i = zone.first[leaf.node[a]]; i < zone.first[leaf.node[a] + 1]; ++i)
        for (int b = 0; b < 10; ++b)
          for (int j = zone.first[leaf.node[b]]; j < zone.first[leaf.node[b] + 1]; ++j)
            if (zone.from[i] <= zone.from[j])
              sum.add(zone.from[i], zone.from[j], zone.weight[i] * zone.weight[j], K.block<3, 3>(3 * a, 3 * b));
  }
  return sum.take();
}

}  // namespace kt
