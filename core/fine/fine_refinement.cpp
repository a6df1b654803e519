#include "core/fine/fine_refinement.hpp"

#include <algorithm>
#include <cmath>

#include "core/fine/fine_surface.hpp"

namespace kt {
namespace {

constexpr int kMostLevels = 8;

/// Corners in the order whose octahedra are cut along their shortest diagonal, between the middles of 02 and of 13.
std::array<int, 4> ordered(const VectorX& x, const Tetrahedron& t) {
  const std::array<std::array<int, 4>, 3> even{{{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}}};
  std::array<int, 4> out{};
  double shortest = 0;
  for (const auto& order : even) {
    const std::array<int, 4> c{t[order[0]], t[order[1]], t[order[2]], t[order[3]]};
    const double length = (node(x, c[0]) + node(x, c[2]) - node(x, c[1]) - node(x, c[3])).norm();
    if (out == std::array<int, 4>{} || length < (1 - 1e-9) * shortest) out = c, shortest = length;
  }
  return out;
}

class Refinement {
 public:
  Refinement(const FineBody& body, std::span<const int> chosen, const FineZoneOptions& options, const FineSize& size,
             FineNodes& nodes)
      : body_(body), x_(body.mesh->x), chosen_(chosen), options_(options), size_(size), nodes_(nodes) {}

  void add_cell(const std::array<int, 4>& corners, int cell) {
    CornerLeaf root{{}, cell, 0};
    for (int c = 0; c < 4; ++c) root.corner[c] = nodes_.at(corner_point(corners[c]));
    refine(root);
  }

  /// Splits leaves that meet others more than one level smaller, until none does.
  void grade() {
    const int most = deepest(leaves_);
    for (bool is_done = false; !is_done;) {
      is_done = true;
      std::vector<CornerLeaf> before;
      before.swap(leaves_);
      for (const CornerLeaf& leaf : before) {
        if (leaf.is_empty || leaf.level + 2 > most || !meets_much_smaller(leaf)) {
          leaves_.push_back(leaf);
          continue;
        }
        is_done = false;
        split(leaf, [&](const CornerLeaf& child) { leaves_.push_back(child); });
      }
    }
  }

  std::vector<CornerLeaf> take() { return std::move(leaves_); }

 private:
  void refine(const CornerLeaf& leaf) {
    std::array<Vec3, 4> p;
    for (int c = 0; c < 4; ++c) p[c] = nodes_[leaf.corner[c]].of(x_);
    const double size = leaf_size(p);
    if (leaf.level == kMostLevels || size <= (1 + 1e-9) * size_.at(away(p, size, options_))) {
      leaves_.push_back(leaf);
      return;
    }
    const auto& [a, b, c, d] = leaf.corner;
    if (holds_nothing(body_, chosen_[static_cast<std::size_t>(leaf.cell)],
                      {nodes_[a], nodes_[b], nodes_[c], nodes_[d]})) {
      leaves_.push_back({leaf.corner, leaf.cell, leaf.level, true});
      return;
    }
    split(leaf, [&](const CornerLeaf& child) { refine(child); });
  }

  template <class Give>
  void split(const CornerLeaf& leaf, const Give& give) {
    const auto& [a, b, c, d] = leaf.corner;
    const int ab = nodes_.between(a, b), ac = nodes_.between(a, c), ad = nodes_.between(a, d),
              bc = nodes_.between(b, c), bd = nodes_.between(b, d), cd = nodes_.between(c, d);
    for (const std::array<int, 4>& child : {std::array{a, ab, ac, ad},
                                            {ab, b, bc, bd},
                                            {ac, bc, c, cd},
                                            {ad, bd, cd, d},
                                            {ab, ac, ad, bd},
                                            {ab, ac, bc, bd},
                                            {ac, ad, bd, cd},
                                            {ac, bc, bd, cd}})
      give(CornerLeaf{child, leaf.cell, leaf.level + 1});
  }

  /// Whether a corner of another leaf lies a quarter of the way along one of its edges, or so inside one of its faces.
  bool meets_much_smaller(const CornerLeaf& leaf) const {
    const auto is_node = [&](const CellPoint& point) { return nodes_.find(point) >= 0; };
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        if (i == j) continue;
        const CellPoint &a = nodes_[leaf.corner[i]], &b = nodes_[leaf.corner[j]], ab = middle(a, b);
        if (is_node(middle(a, ab))) return true;
        for (int k = j + 1; k < 4; ++k)
          if (k != i && is_node(middle(ab, middle(a, nodes_[leaf.corner[k]])))) return true;
      }
    return false;
  }

  const FineBody& body_;
  const VectorX& x_;
  std::span<const int> chosen_;
  const FineZoneOptions& options_;
  const FineSize size_;
  FineNodes& nodes_;
  std::vector<CornerLeaf> leaves_;
};

}  // namespace

double leaf_size(const std::array<Vec3, 4>& p) {
  double longest = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) longest = std::max(longest, (p[i] - p[j]).norm());
  const double cube = std::abs((p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]));
  return std::max(std::cbrt(cube), longest / std::sqrt(3.0));
}

double away(const std::array<Vec3, 4>& p, double size, const FineZoneOptions& options) {
  return options.distance(0.25 * (p[0] + p[1] + p[2] + p[3])) - 0.5 * size;
}

double least_distance(const std::array<Vec3, 4>& p, const Vec3& place) {
  double out = 0;
  for (const auto& face : kFaceCorners) {
    const Vec3 normal = (p[face[1]] - p[face[0]]).cross(p[face[2]] - p[face[0]]).normalized();
    out = std::max(out, normal.dot(place - p[face[0]]));
  }
  return out;
}

std::vector<CornerLeaf> refine_cells(const FineBody& body, std::span<const int> chosen, const FineZoneOptions& options,
                                     const FineSize& size, FineNodes& nodes) {
  Refinement refinement(body, chosen, options, size, nodes);
  for (std::size_t i = 0; i < chosen.size(); ++i)
    refinement.add_cell(ordered(body.mesh->x, body.mesh->tetrahedra[static_cast<std::size_t>(chosen[i])]),
                        static_cast<int>(i));
  refinement.grade();
  return refinement.take();
}

}  // namespace kt
