#pragma once
// What a scene names outside itself, and who may name it. A library is code that runs here and an address is called
// from here: both are named by the person at this computer. One rule for every door that a scene comes through.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// A key that names something outside the scene, and what it names.
struct NamedPlace {
  std::string key;  ///< "tool.path.device.library"
  std::string* place;
};
std::vector<NamedPlace> device_places(Scene& scene);  ///< libraries and addresses that are not empty
std::vector<NamedPlace> scene_files(Scene& scene);    ///< meshes and recordings that are not empty

/// Throws InputError for a library or an address that the door may not name; none has been touched by then. A file may
/// name what is installed here and addresses of this computer; others may name none.
/// @param own   a scene that the person at this computer wrote: what it names may be named again
/// @param from  who brought it, for the message: the scene file's name, "page" ...
void require_named_here(const Scene& scene, const Scene& own, SceneDoor door, const std::string& from);

/// Throws InputError for a file of a scene of others that does not lie beside the scene under a plain name.
void require_beside(const Scene& scene, const Scene& own, const std::string& from);

}  // namespace kt
