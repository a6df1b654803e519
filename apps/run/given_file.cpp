#include "apps/run/given_file.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "haptics/body/body_ranges.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/setup/session_parts.hpp"
#include "io/files/json_file.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

bool holds_session(const std::string& file) {
  try {
    const auto json = read_json_file(file);
    return json.is_object() && json.contains("refreshes") && json.contains("recording");
  } catch (const InputError&) {
    return false;  // a scene with comments, or wrong: load_scene tells
  }
}

/// Its first character opens a group or a comment.
bool begins_as_scene(const std::string& file) {
  std::ifstream in(file);
  char first = 0;
  return in >> first && (first == '{' || first == '/');
}

}  // namespace

Given kind_of_file(const std::string& file) {
  std::error_code none;
  if (fs::is_directory(file, none)) {
    if (!fs::exists(file + "/session.json", none))
      throw InputError(text(file, ": the folder holds no session.json, which a run leaves in its folder --out"));
    return Given::session;
  }
  const std::vector<std::string> meshes = readable_mesh_extensions();
  if (std::ranges::find(meshes, mesh_extension(file)) != meshes.end()) return Given::mesh;
  const bool is_json = mesh_extension(file) == ".json";
  if (is_json && holds_session(file)) return Given::session;
  if (is_json || !fs::is_regular_file(file, none) || begins_as_scene(file)) return Given::scene;
  std::string known;
  for (const std::string& extension : meshes) known += " " + extension;
  throw InputError(
      text(file, ": neither a scene (.json), nor a mesh (", known.substr(1), "), nor the folder of a run"));
}

namespace {

bool sets(const std::vector<std::string>& set, const std::string& key) {
  return std::ranges::any_of(set, [&](const std::string& s) { return s.starts_with(key + "="); });
}

/// Settings are applied to a scene that already names the mesh, so that --set can change everything.
Scene scene_with_body(const std::string& mesh, const std::string& body, const std::vector<std::string>& set,
                      const std::string& model) {
  Scene base = default_scene();
  base.title = "drag over " + fs::path(mesh).filename().string();
  base.duration = 1.2;
  base.object.mesh = mesh;
  base.object.size = 0.1;
  base.object.body = body;
  base.object.model.type = model;
  base.object.repair = body != "lattice";
  base.object.fixed.below = FixedBelow{"z", 0.2};
  base.tool.radius = 0.004;
  base.tool.path.press_drag->depth = 0.003;
  base.tool.path.press_drag->speed = 0.04;
  base.tool.path.press_drag->ease = "minimum_jerk";
  return parse_scene(to_json(base), set, mesh);
}

bool holds_tetrahedra(const std::string& mesh) {
  const std::string extension = mesh_extension(mesh);
  for (const char* surface : {".obj", ".off", ".ply", ".stl"})
    if (extension == surface) return false;
  return !load_mesh(mesh).tetrahedra.empty();
}

}  // namespace

Scene scene_of_mesh(const std::string& mesh, const std::vector<std::string>& set) {
  if (sets(set, "object.body")) {
    Scene asked = scene_with_body(mesh, "mesh", set, "msd");
    return asked.object.body == "lattice" ? scene_with_body(mesh, "lattice", set, "fem") : asked;
  }
  const bool is_surface = !holds_tetrahedra(mesh);
  if (is_surface) {
    Scene scene = scene_with_body(mesh, "lattice", set, "fem");
    const SceneObject& o = scene.object;
    if (o.mesh == mesh && !o.tetrahedralize && !o.repair && why_no_lattice(body_options(scene)).empty() &&
        why_no_lattice(touch_options(scene)).empty())
      return scene;
  }
  return scene_with_body(mesh, "mesh", set, is_surface ? "fem" : "msd");
}

Scene scene_of_file(const std::string& file, const std::vector<std::string>& set) {
  return kind_of_file(file) == Given::mesh ? scene_of_mesh(file, set) : load_scene(file, set);
}

}  // namespace kt
