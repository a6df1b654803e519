#pragma once
// How far two surfaces are from one another.
#include "core/body/mesh.hpp"

namespace kt {

/// Largest distance of either surface's points from the other (Hausdorff), over its corners and samples at most about
/// `spacing` apart: off by at most that. NaN without CGAL.                                            [mesh unit]
double hausdorff_distance(const Mesh& a, const Mesh& b, double spacing);

}  // namespace kt
