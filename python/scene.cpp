#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/body/mesh.hpp"
#include "haptics/body/body.hpp"
#include "haptics/setup/session_parts.hpp"
#include "python/bindings.hpp"

namespace kt {
namespace {

NamedScene make_scene(const std::optional<std::string>& file, const std::vector<std::string>& settings) {
  if (file) return {load_scene(*file, settings), *file};
  return {parse_scene(R"({"object": {"mesh": "-"}})", settings, "settings"), "settings"};
}

/// "object.model.young" -> /object/model/young
nlohmann::ordered_json::json_pointer pointer_of(std::string key) {
  std::ranges::replace(key, '.', '/');
  return nlohmann::ordered_json::json_pointer("/" + key);
}

std::string value_text(const NamedScene& named, const std::string& key) {
  const auto json = nlohmann::ordered_json::parse(to_json(named.scene));
  const bool is_path = key.find_first_of("/~") != std::string::npos;  // of JSON's pointers, not of ours
  const auto pointer = pointer_of(is_path ? "" : key);
  if (!key.empty() && !is_path && json.contains(pointer)) return json.at(pointer).dump();
  const std::vector<std::string> known = known_scene_keys();
  if (std::ranges::find(known, key) == known.end()) throw_unknown("key", key, known);
  const bool is_short = key.ends_with(".mu") && std::ranges::find(known, key + "_static") != known.end();
  if (!is_short || !json.contains(pointer_of(key + "_static"))) return "null";
  const auto both = {value_text(named, key + "_static"), value_text(named, key + "_kinetic")};
  return *both.begin() == *std::prev(both.end()) ? *both.begin() : "null";
}

}  // namespace

void check_body_source(const NamedScene& scene, const py::object& mesh, const py::object& model) {
  if (!mesh.is_none() && !py::isinstance<Mesh>(mesh))
    throw InputError("mesh: must be a kilotouch.Mesh, as load_mesh() gives; a file goes into the scene, object.mesh");
  if (!mesh.is_none() && !model.is_none()) throw InputError("mesh and model: give one, a model has a mesh of its own");
  if (mesh.is_none() && model.is_none() && scene.scene.object.mesh == kGivenMesh)
    throw InputError("object.mesh: the scene names no file; name one, or give mesh= or model=");
}

void bind_scene(py::module_& m) {
  py::class_<NamedScene>(m, "Scene")
      .def(py::init(&make_scene), py::arg("file"), py::arg("settings"))
      .def("_get", &value_text, py::arg("key"))
      .def(
          "_set",
          [](NamedScene& named, const std::string& setting) {
            named.scene = parse_scene(to_json(named.scene), {setting}, named.name);
          },
          py::arg("setting"))
      .def("_keys", [](const NamedScene&) { return known_scene_keys(); })
      .def(
          "to_json", [](const NamedScene& named) { return to_json(named.scene); },
          "Every key with its value, as a scene file. Python's json reads it.")
      .def(py::pickle([](const NamedScene& named) { return py::make_tuple(to_json(named.scene), named.name); },
                      [](const py::tuple& s) {
                        if (s.size() != 2) throw InputError("Scene: pickled by another version");
                        const auto name = s[1].cast<std::string>();
                        return NamedScene{parse_scene(s[0].cast<std::string>(), {}, name), name};
                      }))
      .def(
          "__eq__", [](const NamedScene& a, const NamedScene& b) { return a.scene == b.scene; }, py::is_operator());
}

}  // namespace kt
