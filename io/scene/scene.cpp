#include "io/scene/scene.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "io/files/text_reader.hpp"
#include "io/scene/scene_json.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

const nlohmann::ordered_json& schema() {
  static const auto parsed = nlohmann::ordered_json::parse(scene_schema());
  return parsed;
}

std::string key_of(const std::string& override_text) { return override_text.substr(0, override_text.find('=')); }

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

std::string read_text(const std::string& path) {
  if (fs::is_directory(path)) throw InputError(text(path, ": is a folder, not a scene file"));
  if (!fs::exists(path)) throw InputError(text(path, ": no such scene file, or it cannot be read"));
  return read_whole_file(path);
}

}  // namespace

Scene default_scene() { return {}; }

namespace {

Scene parse_checked(const std::string& json, const std::vector<std::string>& overrides, const std::string& name) {
  nlohmann::json document = parse_scene_document(json, name);
  for (const std::string& entry : overrides) apply_override(document, entry, schema());
  if (const auto problem = find_json_problem(document, schema())) throw_problem(*problem, overrides, name);
  const Scene scene = scene_from_json(document);
  if (const auto problem = find_scene_problem(scene)) throw_problem(*problem, overrides, name);
  return scene;
}

}  // namespace

Scene parse_scene(const std::string& json, const std::vector<std::string>& overrides, const std::string& name) {
  try {
    Scene scene = parse_checked(json, overrides, name);
    for (SceneTool* tool : {&scene.tool, scene.second_tool ? &*scene.second_tool : nullptr})
      if (tool) {
        tool->mesh = with_bytes(tool->mesh);
        if (auto& recording = tool->path.recording) recording = with_bytes(*recording);
      }
    scene.object.mesh = with_bytes(scene.object.mesh);
    return scene;
  } catch (const InputError& error) {
    throw InputError(visible(error.what()));  // keys and words are shown as they stand
  }
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = parse_scene(read_text(path), overrides, path);
  const fs::path folder = fs::path(path).parent_path();
  std::string& mesh = scene.object.mesh;
  if (mesh.empty()) throw_problem({"object.mesh", "is empty: name a mesh file"}, overrides, path);
  mesh = resolve(mesh, folder, is_overridden("object.mesh", overrides));
  const auto resolve_tool = [&](SceneTool& tool, const std::string& name) {
    tool.mesh = resolve(tool.mesh, folder, is_overridden(name + ".mesh", overrides));
    if (auto& recording = tool.path.recording)
      recording = resolve(*recording, folder, is_overridden(name + ".path.recording", overrides));
  };
  resolve_tool(scene.tool, "tool");
  if (scene.second_tool) resolve_tool(*scene.second_tool, "second_tool");
  return scene;
}

std::vector<std::string> known_scene_keys() { return schema_keys(schema()); }

}  // namespace kt
