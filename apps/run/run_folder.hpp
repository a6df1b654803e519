#pragma once
// The folder of a run's results, when it holds results already.
#include <string>

#include "io/scene/scene.hpp"

namespace kt {

enum class FolderHolds { nothing, same_run, other_settings };

/// Whose results are in the folder: none, of this scene, or of this scene with other settings.
/// @throws InputError for those of another scene (another title; without titles, another mesh), unless `force`, and for
/// what cannot be read as a run's
FolderHolds look_at_folder(const std::string& folder, const Scene& scene, bool force);

}  // namespace kt
