#pragma once
// A tool inside the body: how deep, and through which part of the surface the body is pushed off it.
#include <optional>

#include "collision/shape/contact.hpp"
#include "core/local/reducer.hpp"

namespace kt {

/// Where a tool that is inside goes out.
struct WayOut {
  int triangle = -1;  ///< of the surface
  double depth = 0;   ///< of the tool's deepest point below it [m]
};

class WayOutSearch {
 public:
  /// @param fixed  the body's clamped nodes: nothing is pushed off there
  WayOutSearch(const Surface& surface, int num_nodes, const std::vector<int>& fixed);

  /// The shortest way out of the body at positions x (3n), through a triangle whose nodes can all move: what a person
  /// would choose. Nothing for a tool that is outside, and where everything is clamped.
  /// @param least    depth [m] that counts
  /// @param corners  most of the tool's corners that are looked at, evenly picked: a search takes a look at every
  ///                 triangle for each
  std::optional<WayOut> find(const VectorX& x, const ToolShape& tool, const Vec3& place, const Quaternion& turn,
                             double least, int corners) const;

  /// The whole surface as a patch: its vertices are the body's nodes.
  const SurfacePatch& whole() const { return whole_; }

 private:
  SurfacePatch whole_;
  std::vector<char> is_fixed_;  // node
};

}  // namespace kt
