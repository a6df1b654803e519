#pragma once
// Depths of points of cells in the body's material. Zones that follow a tool share most of their points, and a depth
// costs a winding number and a search for the nearest triangle: known depths are kept.
#include <unordered_map>

#include "core/body/embedded_surface.hpp"
#include "core/fine/fine_nodes.hpp"

namespace kt {

/// For one thread at a time.
class KnownDepths {
 public:
  /// Borrows both.
  /// @param x  rest positions of the nodes of cells [m], (3n)
  KnownDepths(const MaterialField& material, const VectorX& x) : material_(material), x_(x) {}

  /// MaterialField::depth(): the same number whatever was asked before.
  /// @param most  depths beyond it are given as it [m]
  double at(int cell, const CellPoint& point, double most);

  /// Depths that are kept.
  std::size_t size() const { return known_.size(); }

 private:
  static constexpr std::size_t kMost = 200'000;  // some 20 MB; then it starts anew
  struct Place {
    int cell = 0;
    CellPoint point;
    bool operator==(const Place&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Place& p) const {
      return CellPointHash()(p.point) ^ static_cast<std::size_t>(p.cell) * 0x9E3779B97F4A7C15ull;
    }
  };
  struct Depth {
    double depth = 0, most = 0;  // at the depth `most` it is only known that it is no less
  };
  const MaterialField& material_;
  const VectorX& x_;
  std::unordered_map<Place, Depth, Hash> known_;  // asked only, never gone through: its order is no matter
};

}  // namespace kt
