#pragma once
// Contact of a tool with one moving triangle in 113-bit arithmetic, by other means than the engine's: the cubic of
// coplanarity for a point, dense sampling of the distance for a sphere. Slow, and only for tests.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Eight points of a query: tool and triangle at both ends of the step.
struct CollisionQuery {
  Vec3 tool_t0, triangle_t0[3], tool_t1, triangle_t1[3];
};

/// The query with the triangle seen from its other side.
CollisionQuery reversed(const CollisionQuery& q);

/// Distance from p to the triangle, right to the last bit of a double.
double exact_distance(const Vec3& p, const Vec3 (&triangle)[3]);
/// The same at time t of the step.
double exact_distance(const CollisionQuery& q, double t);

struct ExactImpact {
  double toi = 0;          ///< of the first contact from outside, nearest double
  bool ambiguous = false;  ///< a contact at or before it is too near an edge or a graze for a verdict
};

/// First crossing of a point from the outside (counter-clockwise side) to the inside of the triangle.
std::optional<ExactImpact> exact_point_impact(const CollisionQuery& q);

/// First time at which a sphere that starts clear of the triangle touches it.
std::optional<ExactImpact> exact_sphere_impact(const CollisionQuery& q, double radius);

}  // namespace kt
