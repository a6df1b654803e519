#pragma once
// First touch of a sphere, or of a point, with a triangle that keeps its shape, in closed form and 113-bit arithmetic:
// the face is a line met by a plane, an edge a quadratic (cylinder), a vertex a quadratic (sphere). For tests.
#include <optional>

#include "tests/support/collision_oracle.hpp"
#include "tests/support/quad_point.hpp"

namespace kt {

struct TranslationTouch {
  enum class Feature { face, edge, vertex } feature = Feature::face;
  quad::Real toi = 0;        ///< unrounded; 0 when they touch at the start
  bool from_behind = false;  ///< the centre is on the clockwise side of the face, or comes from there (a point)
  double closing = 0;       ///< cosine between the motion and the way to the place that is touched: 0 grazes, 1 head-on
  double beside_face = 0;   ///< an edge or vertex is touched: how far the foot lies outside the face, as a weight
  bool touches_t0 = false;  ///< they touch at the start of the step
};

/// Whether all vertices move by the same vector relative to the tool: what the closed form is for.
bool is_translation(const CollisionQuery& q);

/// The first touch in [0, 1], or nothing. The triangle needs an area for a point, not for a sphere.
std::optional<TranslationTouch> first_translation_touch(const CollisionQuery& q, double radius);

/// Distance of the sphere from the triangle at time t, right to the last bits of a double; negative: it overlaps.
double translation_gap(const CollisionQuery& q, double radius, quad::Real t);

}  // namespace kt
