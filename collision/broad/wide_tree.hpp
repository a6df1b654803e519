#pragma once
// Shape of a bounding volume hierarchy with four children a node: which triangle is where. The boxes are its user's.
#include <span>
#include <vector>

#include "collision/shape/swept_box.hpp"

namespace kt {

constexpr int kTreeWidth = 4;
/// Levels that no tree exceeds, whatever the triangles: beyond this depth of binary cuts, ranges are halved by count.
constexpr int kMaxCutDepth = 32, kMaxTreeLevels = kMaxCutDepth + 32;

/// Nodes level by level, the root first, so that a child comes after its parent. Slot 4 i + k is child k of node i.
struct WideTree {
  static constexpr int kEmpty = 0;  ///< in `child`: nothing here (the root is nobody's child)

  std::vector<int> child;        ///< per slot: > 0 a node, < 0 triangle ~child, kEmpty
  std::vector<int> parent_slot;  ///< per node; -1 for the root
  std::vector<int> level_begin;  ///< first node of each level, and their number at the end

  int num_nodes() const { return static_cast<int>(parent_slot.size()); }
  int num_levels() const { return static_cast<int>(level_begin.size()) - 1; }
};

/// Hierarchy over boxes that overlap little, by the surface area heuristic (Wald 2007), every triangle in one slot. At
/// least the root, even without boxes. O(n log n).
WideTree make_wide_tree(std::span<const Box> boxes);

}  // namespace kt
