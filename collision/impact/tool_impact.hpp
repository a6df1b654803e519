#pragma once
// Narrow phase: first time of impact of a point or a sphere with one moving triangle. Method: docs/collision.md.
#include <optional>

#include "collision/shape/contact.hpp"

namespace kt {

/// First time t in [0, 1] at which the tool (point or sphere) moving along `sweep` touches the triangle whose vertices
/// move linearly from a_t0,b_t0,c_t0 to a_t1,b_t1,c_t1, while approaching it.
/// Conservative: never reports later than the true time, never misses; an ambiguous case is a hit at its lower end.
/// A tool that touches at t = 0 and separates is not a hit. Input that is not finite gives no hit (callers validate);
/// nor does one whose largest coordinate, relative to the tool, is out of the valid range of feature_toi.hpp.
/// One-sided: only contact from the outside (the counter-clockwise side) of the triangle counts; see .cpp for the
/// reason. No allocation, no exception.
std::optional<Contact> find_triangle_impact(const ToolShape& tool, const ToolSweep& sweep, const Vec3 (&triangle_t0)[3],
                                            const Vec3 (&triangle_t1)[3]) noexcept;

}  // namespace kt
