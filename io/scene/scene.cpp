#include "io/scene/scene.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "io/files/text_reader.hpp"
#include "io/scene/named_here.hpp"
#include "io/scene/scene_json.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

const nlohmann::ordered_json& schema() {
  static const auto parsed = nlohmann::ordered_json::parse(scene_schema());
  return parsed;
}

std::string key_of(const std::string& override_text) { return split_override(override_text).first; }

/// True when `path` is `key` or lies inside it: "a.b" and "a.b[2]" are inside "a", "ab" is not.
bool is_inside(const std::string& path, const std::string& key) {
  return path.compare(0, key.size(), key) == 0 &&
         (path.size() == key.size() || path[key.size()] == '.' || path[key.size()] == '[');
}

/// Who wrote the value that is wrong: the last override that touches it, else the file.
std::string author(const JsonProblem& problem, const std::vector<std::string>& overrides, const std::string& name) {
  for (auto it = overrides.rbegin(); it != overrides.rend(); ++it)
    if (is_inside(problem.path, key_of(*it)) || (problem.unknown_key && is_inside(key_of(*it), problem.path)))
      return "--set " + *it;
  return name;
}

[[noreturn]] void throw_problem(const JsonProblem& problem, const std::vector<std::string>& overrides,
                                const std::string& name) {
  throw InputError(text(author(problem, overrides, name), ": ", problem.path.empty() ? "the scene" : problem.path, " ",
                        problem.message));
}

bool is_overridden(const std::string& key, const std::vector<std::string>& overrides) {
  for (const std::string& entry : overrides)
    if (is_inside(key, key_of(entry))) return true;
  return false;
}

/// A saved scene has the bytes of a name that are no UTF-8 as \xff (to_json).
std::string with_bytes(const std::string& file) {
  const std::string bytes = unescape_bytes(file);
  return !fs::exists(file) && fs::exists(bytes) ? bytes : file;
}

/// A file named in the scene, seen from the current folder. A word typed on the command line means the current folder
/// if the file is there, as for every other command.
std::string resolve(const std::string& file, const fs::path& folder, bool typed) {
  if (file.empty() || fs::path(file).is_absolute() || (typed && fs::exists(file))) return with_bytes(file);
  return with_bytes((folder / file).lexically_normal().string());
}

/// The scene without the files, libraries and addresses that the command line has not named.
Scene typed_places(Scene scene, const std::vector<std::string>& overrides) {
  for (const auto& places : {device_places(scene), scene_files(scene)})
    for (const NamedPlace& named : places)
      if (!is_overridden(named.key, overrides)) named.place->clear();
  return scene;
}

std::string read_text(const std::string& path) {
  if (fs::is_directory(path)) throw InputError(text(path, ": is a folder, not a scene file"));
  if (!fs::exists(path)) throw InputError(text(path, ": no such scene file, or it cannot be read"));
  return read_whole_file(path);
}

}  // namespace

Scene default_scene() { return {}; }

namespace {

/// "centre" is "center", where that is not there, too.
void take_other_spelling(nlohmann::json& document) {
  const auto at = nlohmann::json::json_pointer("/object/model/inclusions");
  if (!document.is_object() || !document.contains(at) || !document[at].is_array()) return;
  for (nlohmann::json& inclusion : document[at]) {
    if (!inclusion.is_object() || !inclusion.contains("centre") || inclusion.contains("center")) continue;
    inclusion["center"] = inclusion["centre"];
    inclusion.erase("centre");
  }
}

Scene parse_checked(const std::string& json, const std::vector<std::string>& overrides, const std::string& name) {
  nlohmann::json document = parse_scene_document(json, name);
  for (const std::string& entry : overrides) apply_override(document, entry, schema());
  take_other_spelling(document);
  if (const auto problem = find_json_problem(document, schema())) throw_problem(*problem, overrides, name);
  const Scene scene = scene_from_json(document);
  if (const auto problem = find_scene_problem(scene)) throw_problem(*problem, overrides, name);
  return scene;
}

}  // namespace

Scene parse_scene(const std::string& json, const std::vector<std::string>& overrides, const std::string& name) {
  try {
    Scene scene = parse_checked(json, overrides, name);
    for (const NamedPlace& file : scene_files(scene)) *file.place = with_bytes(*file.place);
    return scene;
  } catch (const InputError& error) {
    throw InputError(visible(error.what()));  // keys and words are shown as they stand
  }
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides, SceneDoor door) {
  Scene scene = parse_scene(read_text(path), overrides, path);
  const fs::path folder = fs::path(path).parent_path();
  if (scene.object.mesh.empty()) throw_problem({"object.mesh", "is empty: name a mesh file"}, overrides, path);
  const Scene typed = typed_places(scene, overrides);
  require_named_here(scene, typed, door, path);
  if (door == SceneDoor::others) require_beside(scene, typed, path);
  for (const NamedPlace& file : scene_files(scene))
    *file.place = resolve(*file.place, folder, is_overridden(file.key, overrides));
  for (const NamedPlace& named : device_places(scene))  // a saved scene means the same file from any folder
    if (named.key.ends_with(".library") && named.place->find('/') != std::string::npos)
      *named.place = fs::absolute(*named.place).lexically_normal().string();
  return scene;
}

std::vector<std::string> known_scene_keys() { return schema_keys(schema()); }

}  // namespace kt
