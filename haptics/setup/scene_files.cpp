#include "haptics/setup/scene_files.hpp"

#include "io/files/text_reader.hpp"

namespace kt {

std::function<std::string(const std::string& path)> keeping_reader(std::shared_ptr<SceneFiles> files) {
  return [files = std::move(files)](const std::string& path) {
    const auto known = files->find(path);
    return known != files->end() ? known->second : files->emplace(path, read_whole_file(path)).first->second;
  };
}

}  // namespace kt
