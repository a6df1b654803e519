#pragma once
// The files that a body and its tools were made of, as they were when they were read: what repeats a run holds them.
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace kt {

/// Paths, as the scene names them, and their content.
using SceneFiles = std::map<std::string, std::string>;

/// For load_mesh(): what `files` holds, else the file itself, which `files` holds from then on.
std::function<std::string(const std::string& path)> keeping_reader(std::shared_ptr<SceneFiles> files);

}  // namespace kt
