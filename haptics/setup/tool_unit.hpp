#pragma once
// The unit of a tool's mesh file, where nothing says it.
#include <string>

#include "collision/shape/contact.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// The unit that makes a tool's longest side nearest to a third of the body's.
const char* likely_tool_unit(double longest_in_file, double body);

/// Of the box around a tool, ascending [m].
Vec3 sides_of(const ToolShape& tool);

/// Throws InputError for a mesh tool many times as large as the body, whose scene says neither size nor unit: a file in
/// millimetres takes minutes to touch with.
/// @param name   of the tool in the scene
/// @param sides  of the tool, ascending [m]
/// @param body   longest side [m]
void require_tool_unit(const SceneTool& tool, const std::string& name, const Vec3& sides, double body);

}  // namespace kt
