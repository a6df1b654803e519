#pragma once
// What a page may make of a scene.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// The scene with settings of a page. Devices stay as they are: a hand is in them, and libraries and addresses are this
/// computer's business. Files that the settings name lie in `folder`, links resolved, and are meshes or recordings.
/// Throws InputError, the same for a file that is there and one that is not; none has been opened by then.
/// @param settings  KEY=VALUE
/// @param folder    of the scene
Scene page_scene(const Scene& before, const std::vector<std::string>& settings, const std::string& folder);

/// An error for a page: of a scene's file no more than its name and line, as the words of a file that cannot be read
/// are none of the page's business.
/// @param own  folder of what the page has dropped, whose words it has; empty: none
std::string without_words_of_files(std::string error, const Scene& scene, const std::string& own);

/// A text for a page: temporary folders of this program left out, so that the names of dropped files stand alone.
std::string without_temporary_folders(std::string text);

/// The name under which a dropped file is kept and shown: no folder, nothing hidden, not long; its ending stays.
std::string dropped_name(const std::string& name);

}  // namespace kt
