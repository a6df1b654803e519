#include "apps/run/run_folder.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/outputs/session_file.hpp"
#include "core/base/error.hpp"
#include "io/files/json_file.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string word(const Json& scene, const std::string& key) {
  const Json::json_pointer at(key);
  return scene.is_object() && scene.contains(at) && scene[at].is_string() ? scene[at].get<std::string>() : "";
}

/// What a person calls the run.
std::string name_of(const Json& scene) {
  const std::string title = word(scene, "/title");
  return title.empty() ? fs::path(word(scene, "/object/mesh")).filename().string() : title;
}

}  // namespace

FolderHolds look_at_folder(const std::string& folder, const Scene& scene, bool force) {
  std::error_code none;
  if (!fs::exists(folder + "/summary.json", none) && !fs::exists(folder + "/trace.csv", none))
    return FolderHolds::nothing;
  const std::string cure = "; give another --out, or --force to replace them";
  const Json own = parse_json_text(scene_text(scene), "the scene");
  Json other;
  try {
    other = read_json_file(folder + "/scene.json");
  } catch (const InputError&) {
    if (force) return FolderHolds::other_settings;
    throw InputError(text("--out ", folder, ": holds results, but no scene.json that tells whose", cure));
  }
  if (!force && name_of(own) != name_of(other))
    throw InputError(text("--out ", folder, ": holds the results of another run, \"", name_of(other), "\"", cure));
  return own == other ? FolderHolds::same_run : FolderHolds::other_settings;
}

}  // namespace kt
