#pragma once
// Where a ball or a capsule touches vertices of a surface: the contacts on cells that are refined for it. Their faces
// are quadratic, and flat facets between their nodes lie up to an eighth of the edge squared over the radius too high;
// held at the nodes alone, the faces lie on a ball that is pressed in.
#include "collision/held/moving_tool.hpp"
#include "collision/held/surface_contacts.hpp"

namespace kt {

/// Whether a tool's core is a point or one edge.
inline bool has_vertex_contacts(const ToolCore& core) noexcept { return core.corners.size() <= 2; }

/// Adds the contacts with a gap below `margin` [m] of the vertices of these triangles, each once, seen from outside:
/// the core is on the outer side.
/// @param is_seen  of vertices: false before and after
void add_vertex_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius,
                         double margin, std::span<const int> triangles, std::vector<char>& is_seen,
                         ContactSet& out) noexcept;

}  // namespace kt
