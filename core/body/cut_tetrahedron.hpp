#pragma once
// The part of a tetrahedron that lies on one side of a plane.
#include "core/base/types.hpp"

namespace kt {

/// Mean of the weights of the four corners over the part where a linear function is positive, times that part's share
/// of the volume. The sum is the share.
/// @param depth  of the function at the corners
Eigen::Vector4d cut_tetrahedron(const Eigen::Vector4d& depth);

}  // namespace kt
