#pragma once
// Where a tool of any shape but a point touches a surface at rest: the contacts that the solver holds as constraints.
#include "collision/moving_tool.hpp"
#include "collision/surface_contacts.hpp"

namespace kt {

/// Contacts with a gap below `margin` [m], among `candidates` (triangles) and their neighbours, seen from outside.
///
/// A sphere about any place of the core is part of the tool, so that it must not get into the surface is always true.
/// The places are: each corner of the core; where one of its edges is nearest to an edge of the surface; where one of
/// its triangles is nearest to a vertex of the surface. Each has the contacts of its sphere (find_sphere_contacts()).
/// `start` (or -1): a triangle touched before; a corner that has gone through the surface there is pushed out.
/// `way` [m]: that the tool has come since it was outside, as in find_sphere_contacts().
/// `overlap` [m]: that it may have besides, as one that is pushed out.
void find_tool_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
                        std::span<const int> candidates, int start, ContactSet& out, const Vec3& way = Vec3::Zero(),
                        double overlap = 0) noexcept;

}  // namespace kt
