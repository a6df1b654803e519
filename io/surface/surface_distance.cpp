#include "io/surface/surface_distance.hpp"

#include <algorithm>
#include <limits>

#include "io/surface/repair_cgal.hpp"

namespace kt {

double hausdorff_distance([[maybe_unused]] const Mesh& a, [[maybe_unused]] const Mesh& b,
                          [[maybe_unused]] double spacing) {
#if KT_WITH_CGAL
  return std::max(sampled_distance_cgal(a, b, spacing), sampled_distance_cgal(b, a, spacing));
#else
  return std::numeric_limits<double>::quiet_NaN();
#endif
}

}  // namespace kt
