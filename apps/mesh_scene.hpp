#pragma once
// A scene for a mesh alone.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// A tenth of a metre, soft as tissue, held at the far side; a sphere presses and drags over the near side.
/// Sizes follow the body's own size, so that any mesh in any unit gives a sensible first contact.
/// @param set  KEY=VALUE
Scene scene_of_mesh(const std::string& mesh, const std::vector<std::string>& set);

}  // namespace kt
