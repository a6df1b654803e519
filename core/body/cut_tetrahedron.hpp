#pragma once
// The part of a tetrahedron that lies on one side of a plane.
#include <array>

#include "core/base/types.hpp"

namespace kt {

/// Edges of a tetrahedron; nodes 4 to 9 of a quadratic one are their middles.
inline constexpr int kCellEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// The eight tetrahedra between these ten nodes: four at the corners, four around the diagonal between the middles of
/// edges 20 and 13.
inline constexpr std::array<std::array<int, 4>, 8> kEighths{
    {{0, 4, 6, 7}, {1, 4, 5, 8}, {2, 5, 6, 9}, {3, 7, 8, 9}, {6, 8, 4, 5}, {6, 8, 5, 9}, {6, 8, 9, 7}, {6, 8, 7, 4}}};

/// Weights of the corners at four points, each nearest to one of them, that integrate polynomials of degree two
/// exactly.
inline constexpr double kNearShare = 0.58541019662496845, kFarShare = 0.13819660112501051;

/// Mean of the weights of the four corners over the part where a linear function is positive, times that part's share
/// of the volume. The sum is the share.
/// @param depth  of the function at the corners
Eigen::Vector4d cut_tetrahedron(const Eigen::Vector4d& depth);

}  // namespace kt
