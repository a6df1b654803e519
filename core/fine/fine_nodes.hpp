#pragma once
// Nodes of cells that are refined again and again, each at a mean of the corners of one coarse cell. Exact integers, so
// that cells side by side make the same node, and the numbering depends on their order alone.
#include <span>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// A point of a coarse cell: corners of the body's mesh in ascending order, with weights in 1/kOne; sum kOne.
struct CellPoint {
  static constexpr int kOne = 1 << 20;
  int count = 0;
  std::array<int, 4> corner{};
  std::array<int, 4> weight{};
  bool operator==(const CellPoint&) const = default;

  double share(int k) const { return static_cast<double>(weight[k]) / kOne; }
  Vec3 of(const VectorX& x) const {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < count; ++k) sum += share(k) * node(x, corner[k]);
    return sum;
  }
  /// Whether it lies on the face, edge or corner that these corners span.
  bool lies_on(std::span<const int> corners) const;
};

CellPoint corner_point(int corner);
CellPoint middle(const CellPoint& a, const CellPoint& b);

struct CellPointHash {
  std::size_t operator()(const CellPoint& p) const {
    std::size_t out = 0;
    for (int k = 0; k < p.count; ++k)
      for (const int value : {p.corner[k], p.weight[k]})
        out = (out ^ static_cast<std::size_t>(value)) * 0x9E3779B97F4A7C15ull, out ^= out >> 29;
    return out;
  }
};

class FineNodes {
 public:
  /// The number of the node there, a new one if there is none.
  int at(const CellPoint& point);
  /// -1: there is none.
  int find(const CellPoint& point) const;
  int between(int a, int b) { return at(middle(points_[a], points_[b])); }
  const CellPoint& operator[](int i) const { return points_[i]; }
  int size() const { return static_cast<int>(points_.size()); }
  /// None, in the memory that it has.
  void clear();

 private:
  std::size_t slot_of(const CellPoint& point) const;
  void widen();

  std::vector<CellPoint> points_;
  /// Their numbers by hash, twice as many slots as there are points or more, a power of two; -1: free. A point is in
  /// the first free slot from its hash on. Zones are made of thousands of points, each asked for some ten times.
  std::vector<int> slots_;
};

}  // namespace kt
