#pragma once
// What a page has to be told once of a body: its surface, without the nodes inside.
#include <string>
#include <vector>

#include "core/body/surface.hpp"

namespace kt {

struct BodyShape {
  std::vector<int> nodes;           ///< of the body, that lie on its surface
  std::vector<int> place;           ///< of each node of the body in `nodes`, -1
  std::vector<int> fixed;           ///< clamped ones: indices into `nodes`
  std::vector<Triangle> triangles;  ///< indices into `nodes`; as many as the surface's, in its order
};

/// @param fixed  nodes of the body that are clamped
BodyShape make_body_shape(const Surface& surface, int num_nodes, const std::vector<int>& fixed);

}  // namespace kt
