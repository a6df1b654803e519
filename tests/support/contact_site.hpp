#pragma once
// Where a test's tool is about to touch.
#include <limits>

#include "core/body/surface.hpp"
#include "core/local/reducer.hpp"

namespace kt {

/// In the middle of the surface triangle whose middle is nearest to `at`. Nodes of the body at x.
inline ContactSite site_near(const Surface& surface, const VectorX& x, const Vec3& at, double reach) {
  ContactSite out{.reach = reach};
  double best = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    Vec3 centroid = Vec3::Zero();
    for (int i : surface.triangles[t]) centroid += node(x, i) / 3;
    if (const double d = (centroid - at).norm(); d < best) {
      best = d;
      out.centre = centroid;
      out.triangle = t;
    }
  }
  return out;
}

}  // namespace kt
