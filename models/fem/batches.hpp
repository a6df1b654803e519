#pragma once
// Elements four by four, so that their arithmetic runs side by side, and in slabs, so that several threads can sum.
#include <span>

#include "models/fem/block_pattern.hpp"
#include "models/fem/element.hpp"
#include "models/fem/lanes.hpp"
#include "models/fem/slabs.hpp"

namespace kt {

constexpr int num_pairs(int nodes) { return nodes * (nodes - 1) / 2; }

/// Four elements of N nodes. Nodes ascend, so that pair (a, b), a < b, is a block of the matrix above the diagonal.
template <int N>
struct Batch {
  struct Point {
    std::array<LaneVec3, N> g;  ///< rest gradients of the shape functions [1/m], their sum zero
    Lanes volume;  ///< weight of the point [m^3], times the element's factor: stress is proportional to young
  };
  int count = 0;  ///< elements: fewer than four at the end of a slab; lanes beyond repeat the first one
  std::array<std::array<int, N>, Lanes::kCount> nodes;
  std::array<std::array<int, num_pairs(N)>, Lanes::kCount> blocks;  ///< of pairs (0,1) (0,2) (1,2) (0,3) ...
};

template <int N>
class Batches {
 public:
  using Point = typename Batch<N>::Point;

  /// @param factors  of the elements' stress; empty: 1
  Batches(const ElementTable<N>& table, const BlockPattern& pattern, const std::vector<double>& factors)
      : points_per_element_(static_cast<std::size_t>(table.points_per_element)) {
    const Slabs slabs = make_slabs<N>(table.mesh.num_nodes(), table.nodes);
    for (int s = 0; s < slabs.count(); ++s) {
      slab_begin_.push_back(static_cast<int>(batches_.size()));
      for (int k = slabs.begin[s]; k < slabs.begin[s + 1]; k += Lanes::kCount)
        append(table, pattern, factors, {slabs.elements.data() + k, slabs.elements.data() + slabs.begin[s + 1]});
    }
    slab_begin_.push_back(static_cast<int>(batches_.size()));
  }

  /// Calls work(batch, its points) for all, in parallel over slabs that share no node.
  template <class Work>
  void for_each(const Work& work) const {
    const int slabs = static_cast<int>(slab_begin_.size()) - 1;
    for (int parity : {0, 1})
      parallel_for((slabs + 1 - parity) / 2, [&](int i) {
        const int slab = 2 * i + parity;
        for (int k = slab_begin_[slab]; k < slab_begin_[slab + 1]; ++k)
          work(batches_[k], std::span<const Point>(points_.data() + points_per_element_ * static_cast<std::size_t>(k),
                                                   points_per_element_));
      });
  }

 private:
  /// One batch of the first of `elements`.
  void append(const ElementTable<N>& table, const BlockPattern& pattern, const std::vector<double>& factors,
              std::span<const int> elements) {
    Batch<N> batch;
    batch.count = static_cast<int>(std::min<std::size_t>(Lanes::kCount, elements.size()));
    std::vector<Point> points(points_per_element_);
    for (int lane = 0; lane < Lanes::kCount; ++lane) {
      const std::size_t e = static_cast<std::size_t>(elements[lane < batch.count ? lane : 0]);
      const double factor = factors.empty() ? 1 : factors[e];
      std::array<int, N> order;
      std::iota(order.begin(), order.end(), 0);
      std::sort(order.begin(), order.end(), [&](int a, int b) { return table.nodes[e][a] < table.nodes[e][b]; });
      for (int a = 0; a < N; ++a) batch.nodes[lane][a] = table.nodes[e][order[a]];
      for (int b = 0, pair = 0; b < N; ++b)
        for (int a = 0; a < b; ++a)
          batch.blocks[lane][pair++] = pattern.block(batch.nodes[lane][a], batch.nodes[lane][b]);
      for (std::size_t q = 0; q < points_per_element_; ++q) {
        const auto& from = table.points[points_per_element_ * e + q];
        points[q].volume.set(lane, factor * from.volume);
        for (int a = 0; a < N; ++a) set_lane(points[q].g[a], lane, from.gradient.col(order[a]));
      }
    }
    batches_.push_back(batch);
    points_.insert(points_.end(), points.begin(), points.end());
  }

  std::size_t points_per_element_;
  std::vector<Batch<N>> batches_;
  std::vector<Point> points_;
  std::vector<int> slab_begin_;
};

}  // namespace kt
