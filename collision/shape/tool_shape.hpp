#pragma once
#include "collision/shape/contact.hpp"
#include "core/body/mesh.hpp"

namespace kt {

/// Radius of the ball about the reference point that holds the tool [m].
double tool_reach(const ToolShape& tool) noexcept;

/// A capsule along z, and a mesh tool, about their reference points. Throws InputError when the mesh is empty, not
/// finite, or the radius is not positive.
ToolShape make_capsule(double radius, double length);
ToolShape make_mesh_tool(const Mesh& mesh, double radius);

}  // namespace kt
