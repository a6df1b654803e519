#include "core/fine/fine_stiffness.hpp"

#include "core/fine/leaf_stiffness.hpp"

namespace kt {
namespace {

/// dP/dF at the points of leaves.
class LeafModuli {
 public:
  LeafModuli(const FineBody& body, const FineZone& zone, const FineState& state)
      : body_(body), zone_(zone), state_(state), of_cell_(zone.cells.size()) {}

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
  Pattern sum(zone);
  for (const FineLeaf& leaf : zone.leaves) {
    std::array<Vec3, 4> corners;
    Vec3 middle = Vec3::Zero();
    for (int c = 0; c < 4; ++c) {
      corners[c] = zone.nodes[leaf.node[c]].of(body.mesh->x);
      middle += 0.25 * corners[c];
    }
    const LeafMatrix K = body.material->stiffness_factor(middle) * leaf_stiffness(corners, moduli.of(leaf));
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
