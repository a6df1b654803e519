#pragma once
// The shape that touches a body.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

constexpr int kMaxTools = 2;  ///< most tools that touch one body at the same time, two hands

/// The shape that touches the body, a core rounded by `radius`. The reference point is the origin of the core.
struct ToolShape {
  enum class Kind { point, sphere, capsule, mesh } kind = Kind::point;
  double radius = 0;            ///< [m], 0 for a point, else > 0
  std::vector<Vec3> corners{};  ///< corners of the core [m], none (the reference point), a capsule's two, a mesh's
  std::vector<Triangle> triangles{};  ///< triangles of a mesh
  bool operator==(const ToolShape&) const = default;
};

/// Radius of the ball about the reference point that holds the tool [m].
double tool_reach(const ToolShape& tool) noexcept;

/// A capsule along z, and a mesh tool, about their reference points. Throws InputError when the mesh is empty, not
/// finite, or the radius is not positive.
ToolShape make_capsule(double radius, double length);
ToolShape make_mesh_tool(const Mesh& mesh, double radius);

}  // namespace kt
