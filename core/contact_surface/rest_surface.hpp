#pragma once
// A smooth surface through the nodes of a body at rest, for refined cells: their vertices are raised onto it. It is
// Loop's, whose control points are moved out until it passes by the nodes: a scan's nodes lie on what was scanned.
// Only the vertices' places are smooth. They move as the body's cells and their own yield say, so that the surface lies
// where the body's is however deep a tool is pressed in. One whose motion is smooth, too, lies above a dent, 1 +
// 0.18 h/a times as stiff.
#include <array>
#include <unordered_map>

#include "core/body/surface.hpp"
#include "core/local/fine_patch.hpp"

namespace kt {

/// For one thread at a time: what was found of a triangle is kept.
class RestSurface {
 public:
  /// Borrows the surface, whose vertices are nodes.
  /// @param x  of the body at rest [m]
  RestSurface(const Surface& surface, const VectorX& x);

  /// From a point of a triangle to the smooth surface [m].
  Vec3 offset(int triangle, const Vec3& bary);

  /// Fills the offsets of a patch of this surface.
  void raise(FinePatch& fine);

 private:
  static constexpr std::size_t kMost = 20'000;  // triangles that are kept, 8 MB; then it starts anew
  /// Loop's surface is a quartic over a triangle whose vertices have six neighbours each: its 15 values tell it all.
  using Quartic = std::array<Vec3, 15>;
  const Quartic& over(int triangle);
  const Surface& surface_;
  VectorX x_, control_;
  std::unordered_map<int, Quartic> known_;
};

}  // namespace kt
