#pragma once
// Triangles of a surface that can be the nearest one to a place.
#include <limits>

#include "core/body/embedded_surface.hpp"
#include "core/body/surface.hpp"

namespace kt {

/// A box around the corners of the cells of a group, and somewhat more: vertices may be just outside of their cells.
inline std::array<Vec3, 2> box_of_group(const EmbeddedGroups& groups, int group, const VectorX& x) {
  constexpr double kMargin = 0.1;  // of the extent
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int k = groups.first_node[group]; k < groups.first_node[group + 1]; ++k) {
    low = low.cwiseMin(node(x, groups.node[k]));
    high = high.cwiseMax(node(x, groups.node[k]));
  }
  const Vec3 margin = kMargin * (high - low);
  return {low - margin, high + margin};
}

/// Calls consider(triangle) for all that can be nearer to a place than the root of `nearest_sq`, which it lowers: of an
/// embedded surface not for those in cells that are further away.
/// @param x  positions of the body (3n)
template <class Consider>
void for_each_near(const Surface& surface, const VectorX& x, const Vec3& place, const double& nearest_sq,
                   const Consider& consider) {
  if (!surface.embedded) {
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) consider(t);
    return;
  }
  const EmbeddedGroups& groups = surface.embedded->groups;
  for (int g = 0; g < groups.count(); ++g) {
    const auto [low, high] = box_of_group(groups, g, x);
    if ((place - place.cwiseMax(low).cwiseMin(high)).squaredNorm() >= nearest_sq) continue;
    for (int k = groups.first_triangle[g]; k < groups.first_triangle[g + 1]; ++k) consider(groups.triangle[k]);
  }
}

}  // namespace kt
