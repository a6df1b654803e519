#pragma once
// Broad and narrow phase together: the earliest impact of the swept tool with a set of moving triangles.
#include <optional>
#include <span>

#include "collision/broad/triangle_index.hpp"
#include "collision/held/moving_tool.hpp"
#include "collision/impact/tool_impact.hpp"

namespace kt {

/// The earliest impact over all candidate triangles of `index` (already refitted to `surface`), or nothing.
/// @param ignored  per triangle: non-zero = an active contact that the solver already holds as a constraint, skip it;
///                 empty = none
/// @param scratch  room for surface.triangles.size() indices
/// Ties go to the lower triangle index, so that the result does not depend on the backend. No allocation.
std::optional<Contact> find_first_contact(const TriangleIndex& index, const MovingTriangles& surface,
                                          const ToolShape& tool, const ToolSweep& sweep,
                                          std::span<const unsigned char> ignored, std::span<int> scratch) noexcept;

/// The same for a tool of any shape, taken along its sweep before (MovingTool::move).
std::optional<Contact> find_first_contact(const TriangleIndex& index, const MovingTriangles& surface,
                                          const MovingTool& tool, std::span<const unsigned char> ignored,
                                          std::span<int> scratch) noexcept;

/// First impact with one triangle; of tools with a core, one at `until` or later may be left out.
std::optional<Contact> find_tool_impact(const MovingTool& tool, const Vec3 (&triangle_t0)[3],
                                        const Vec3 (&triangle_t1)[3], double until = 1) noexcept;

}  // namespace kt
