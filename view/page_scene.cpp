#include "view/page_scene.hpp"

#include <algorithm>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/scene/named_here.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// Inside the folder, and neither hidden nor in a hidden folder.
bool lies_in(const fs::path& path, const fs::path& folder) {
  const fs::path inside = path.lexically_relative(folder);
  return !inside.empty() &&
         std::ranges::none_of(inside, [](const fs::path& part) { return part.native().starts_with('.'); });
}

bool has_ending_of_a_scenes_file(const std::string& key, const fs::path& path) {
  const std::vector<std::string> meshes = readable_mesh_extensions();
  if (key.ends_with(".mesh")) return std::ranges::find(meshes, mesh_extension(path.string())) != meshes.end();
  return path.extension() == ".csv" || path.extension() == ".txt";
}

/// The whole path of a file that a page names; empty: it may not.
std::string allowed_file(const NamedPlace& named, const std::string& folder) {
  std::error_code error;
  const fs::path top = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return {};
  const fs::path path = fs::weakly_canonical(top / *named.place, error);
  if (error || !lies_in(path, top) || !has_ending_of_a_scenes_file(named.key, path)) return {};
  return fs::exists(path, error) && !fs::is_regular_file(path, error) ? std::string() : path.string();
}

void confine_files(Scene& scene, const Scene& before, const std::string& folder) {
  Scene old = before;
  const std::vector<NamedPlace> known = scene_files(old);
  for (const NamedPlace& named : scene_files(scene)) {
    if (std::ranges::any_of(known, [&](const NamedPlace& k) { return k.key == named.key && *k.place == *named.place; }))
      continue;
    const std::string path = allowed_file(named, folder);
    if (path.empty())
      throw InputError(
          text("page: ", named.key, " is \"", visible(*named.place),
               "\", must be a mesh or a recording (.csv, .txt) in the scene's folder; a mesh from elsewhere "
               "can be dropped into the page"));
    *named.place = path;
  }
}

void keep_device(const SceneTool& tool, const SceneTool* before, const std::string& name) {
  if (!tool.path.device || (before && before->path.device == tool.path.device)) return;
  throw InputError(text("page: ", name, ".path.device: a device is set up on its own computer, by --device or --set ",
                        name, ".path.device... of kilotouch view"));
}

}  // namespace

Scene page_scene(const Scene& before, const std::vector<std::string>& settings, const std::string& folder) {
  Scene out = parse_scene(to_json(before), settings, "page");
  keep_device(out.tool, &before.tool, "tool");
  if (out.second_tool)
    keep_device(*out.second_tool, before.second_tool ? &*before.second_tool : nullptr, "second_tool");
  confine_files(out, before, folder);
  return out;
}

std::string without_words_of_files(std::string error, const Scene& scene, const std::string& own) {
  Scene named = scene;
  for (const NamedPlace& file : scene_files(named)) {
    if (!own.empty() && file.place->starts_with(own)) continue;
    const std::size_t at = error.find(*file.place + ":");
    if (at == std::string::npos) continue;
    std::size_t end = at + file.place->size() + 1;
    while (end < error.size() && error[end] >= '0' && error[end] <= '9') ++end;
    if (end == at + file.place->size() + 1) continue;  // of the whole file: what it describes
    error.resize(end);
    error += text(": is no ", file.key.ends_with("recording") ? "recording" : "mesh",
                  " that can be read; kilotouch run on the computer that has the file says why");
  }
  return error;
}

std::string without_temporary_folders(std::string text) {
  constexpr std::size_t kLetters = 6;  // mkdtemp's
  const std::string own = "kilotouch-";
  std::error_code none;
  const std::string start = (fs::temp_directory_path(none) / own).string();
  for (std::size_t at = 0; (at = text.find(start, at)) != std::string::npos;) {
    std::size_t end = at + start.size() - own.size();
    while (text.compare(end, own.size(), own) == 0 && end + own.size() + kLetters < text.size() &&
           text[end + own.size() + kLetters] == '/')
      end += own.size() + kLetters + 1;
    if (end < at + start.size()) {
      at = end + 1;
      continue;
    }
    text.erase(at, end - at);
  }
  return text;
}

std::string dropped_name(const std::string& name) {
  constexpr std::size_t kMostShown = 100;  // bytes
  const std::string shown = visible(name.substr(name.find_last_of("/\\") + 1));
  const bool is_usable = !shown.starts_with('.') && shown.size() <= kMostShown && shown.find('\\') == std::string::npos;
  return is_usable ? shown : "dropped" + mesh_extension(name);
}

}  // namespace kt
