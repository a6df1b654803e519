#pragma once
// A point that moves with some of a body's nodes: of a triangle its three, of a smooth surface their neighbours, too.
#include <algorithm>

#include "core/base/types.hpp"

namespace kt {

/// Weights of a surface point on a body's nodes, sum 1.
struct NodeWeights {
  static constexpr int kMost =
      64;  // refined triangles whose corners are in three ten-node cells: 30, and as many of leaves
  int count = 0;
  std::array<int, kMost> node;  // entries from count on: anything
  std::array<double, kMost> weight;

  NodeWeights() noexcept {}  // leaves the room as it is: ticks make many
  NodeWeights(const NodeWeights& other) noexcept { *this = other; }
  NodeWeights& operator=(const NodeWeights& other) noexcept {
    count = other.count;
    std::copy_n(other.node.data(), count, node.data());
    std::copy_n(other.weight.data(), count, weight.data());
    return *this;
  }
  /// Of a point of a flat triangle.
  NodeWeights(const std::array<int, 3>& nodes, const Vec3& bary) noexcept {
    for (int c = 0; c < 3; ++c) add(nodes[c], bary[c]);
  }
  void add(int i, double w) noexcept {
    node[count] = i;
    weight[count++] = w;
  }
  Vec3 of(const VectorX& x) const noexcept {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < count; ++k) sum += weight[k] * kt::node(x, node[k]);
    return sum;
  }
  void add_to(VectorX& x, const Vec3& value) const noexcept {
    for (int k = 0; k < count; ++k) kt::node(x, node[k]) += weight[k] * value;
  }
};

}  // namespace kt
