#pragma once
// Stiffness of a quadratic tetrahedron with straight edges.
#include <span>

#include "core/body/cut_tetrahedron.hpp"
#include "core/body/refinable.hpp"

namespace kt {

/// Where a leaf is integrated: kNearShare and kFarShare.
constexpr int kLeafPoints = 4;

using LeafMatrix = Eigen::Matrix<double, 30, 30>;
/// Of the four corners and the middles of the edges 01 12 20 03 13 23, (30 x 30) [N/m]; of either orientation.
/// @param corners  at rest [m]
/// @param moduli   of each point
LeafMatrix leaf_stiffness(const std::array<Vec3, 4>& corners, const std::array<const Moduli*, kLeafPoints>& moduli);

/// A place where a leaf is integrated, as shares of its corners, and its share of the leaf's volume.
struct LeafPoint {
  Eigen::Vector4d shares;
  double weight;
};
/// Of a leaf that is material in part, and strained alike everywhere.
LeafMatrix leaf_stiffness(const std::array<Vec3, 4>& corners, const Moduli& moduli, std::span<const LeafPoint> points);

/// Gradients of the ten shape functions at a place, given as shares of the corners, (3 x 10) [1/m].
/// @param gradients  of the shares, (3 x 4) [1/m]
Eigen::Matrix<double, 3, 10> quadratic_gradients(const Eigen::Matrix<double, 3, 4>& gradients,
                                                 const Eigen::Vector4d& shares);

/// Gradients of the shares of four corners, (3 x 4) [1/m].
Eigen::Matrix<double, 3, 4> share_gradients(const std::array<Vec3, 4>& corners);

}  // namespace kt
