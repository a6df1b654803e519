#pragma once
// Leaves of refined cells, by their corners.
#include <algorithm>

#include "core/fine/fine_zone.hpp"

namespace kt {

struct CornerLeaf {
  std::array<int, 4> corner;
  int cell, level;
  bool is_empty = false;  // it holds no material, and is not split further
};

/// The leaves of the cells, graded two to one across faces and edges; `nodes`: their corners, and nothing else.
/// @param size  in the place of that of the options
std::vector<CornerLeaf> refine_cells(const FineBody& body, std::span<const int> chosen, const FineZoneOptions& options,
                                     const FineSize& size, FineNodes& nodes);

/// How often the smallest leaf was split.
template <class Leaf>
int deepest(const std::vector<Leaf>& leaves) {
  int out = 0;
  for (const Leaf& leaf : leaves) out = std::max(out, leaf.level);
  return out;
}

/// Edge of the cube that six leaves of this size fill [m]; of a flat one what its longest edge comes to.
double leaf_size(const std::array<Vec3, 4>& corners);

/// About how far a leaf is from where a tool touches, of that leaf_size(); below 0: there [m].
double away(const std::array<Vec3, 4>& corners, double size, const FineZoneOptions& options);

/// At least how far a place is from a leaf [m]: 0 inside.
double least_distance(const std::array<Vec3, 4>& corners, const Vec3& place);

}  // namespace kt
