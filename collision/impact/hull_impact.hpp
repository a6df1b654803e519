#pragma once
// Narrow phase for tools that are not a point or a sphere: a capsule (a segment with a radius) or a triangle of a mesh
// tool, moving and turning, against one moving triangle. Same certificate as tool_impact.hpp; docs/collision.md.
#include <optional>

#include "collision/shape/contact.hpp"

namespace kt {

/// A convex piece of a tool: one to three corners, each moving on a straight line, rounded by `radius`.
struct MovingHull {
  Vec3 x_t0[3], x_t1[3];  ///< [m]
  int corners = 1;
  double radius = 0;  ///< [m], >= 0: of the shape
  double swell = 0;   ///< [m], >= 0: how far its points get off their straight lines within the step (sagitta())
};

/// First time t in [0, 1] at which the hull touches the triangle while coming nearer. What is promised is what
/// find_triangle_impact() promises: never late, never missed, ambiguous is a hit; touching at the start is a hit only
/// when it comes nearer somewhere; from within the body it passes out, where face meets corner; a number that is not
/// finite, or out of the valid range of feature_toi.hpp, gives no hit. `bary` are the triangle's weights; the normal
/// goes from the triangle to the hull. A hit at `until` or later is not looked for.
std::optional<Contact> find_hull_impact(const MovingHull& hull, const Vec3 (&triangle_t0)[3],
                                        const Vec3 (&triangle_t1)[3], double until = 1) noexcept;

/// How far a point at `arm` [m] from the axis gets off its straight line while it turns by `angle` [rad] in a step, at
/// most: arm (1 - cos(angle / 2)), and 2 arm from half a turn on.
double sagitta(double arm, double angle) noexcept;

}  // namespace kt
