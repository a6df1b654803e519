#pragma once
// Where a ball or a capsule touches vertices of a surface: the contacts on cells that are refined for it. Their faces
// are quadratic, and flat facets between their nodes lie up to an eighth of the edge squared over the radius too high;
// held at the nodes alone, the faces lie on a ball that is pressed in.
#include "collision/held/moving_tool.hpp"
#include "collision/held/surface_contacts.hpp"

namespace kt {

/// Whether a tool's core is a point or one edge.
inline bool has_vertex_contacts(const ToolCore& core) noexcept { return core.corners.size() <= 2; }

/// Which vertices a tool is held at where there are more than there is room for: the same ones for all of a tick.
struct ChosenVertices {
  bool is_made = false;
  std::vector<char> is_left_out;  ///< of vertices; of no meaning before a choice
};

/// Adds the contacts with a gap below `margin` [m] of the vertices of these triangles, each once, seen from outside:
/// the core is on the outer side. Of more than there is room for, those that are nearest with the surface at
/// `x_before`; where more than that touch there, those nearest to their middle, and where half as many more do, some
/// that lie apart (chosen_places.hpp); only those from then on.
/// @param is_place of vertices: those that tools are held at; empty: all
/// @param x_before where the surface was, in contact
/// @param room     how many are added at most
/// @param is_seen  of vertices: false before and after
/// @param chosen   with room for all vertices
void add_vertex_contacts(const SurfacePatch& patch, const VectorX& x, const VectorX& x_before, const ToolCore& core,
                         double radius, double margin, std::span<const int> triangles, std::span<const char> is_place,
                         int room, std::vector<char>& is_seen, ChosenVertices& chosen, ContactSet& out) noexcept;

}  // namespace kt
