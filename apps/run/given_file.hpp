#pragma once
// What a person names to run or to see: a scene, a mesh, a recorded session or the folder of a run.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

enum class Given { scene, mesh, session };

/// By the name, then by what the file holds. @throws InputError: none of them
Given kind_of_file(const std::string& file);

/// A scene for a mesh alone: a tenth of a metre, soft as tissue, held at the far side; a sphere presses and drags over
/// the near side. Sizes follow the body's own size, so that any mesh in any unit gives a sensible first contact.
/// A surface is put into a lattice (object.body) of elements. Where a setting asks for something that a lattice has
/// not, it is filled with tetrahedra, elements as well. A file with tetrahedra keeps them, as springs.
/// @param set  KEY=VALUE
Scene scene_of_mesh(const std::string& mesh, const std::vector<std::string>& set);

/// Of a scene file or of a mesh. @throws InputError
Scene scene_of_file(const std::string& file, const std::vector<std::string>& set);

}  // namespace kt
