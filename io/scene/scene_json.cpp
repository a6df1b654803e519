// The schema's list of fields serves both directions, so what is written is what is read.
#include "io/scene/scene_json.hpp"

#include <nlohmann/json.hpp>

#include "core/base/visible_text.hpp"
#include "io/scene/key_facts.hpp"

namespace kt {
namespace {

using Ordered = nlohmann::ordered_json;  // a saved scene keeps the order of the structs

/// Takes the fields that the document has.
class Reader {
 public:
  explicit Reader(const nlohmann::json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, T& value, const KeyFacts& = {}) const {
    if (json_.contains(key)) read(json_.at(key), value);
  }

 private:
  static void read(const nlohmann::json& json, Vec3& v) { v = Vec3(json[0], json[1], json[2]); }
  static void read(const nlohmann::json& json, Waypoint& w) { w = {json[0], Vec3(json[1], json[2], json[3])}; }

  template <class T>
  static void read(const nlohmann::json& json, std::optional<T>& value) {
    read(json, value.emplace());
  }

  template <class T>
  static void read(const nlohmann::json& json, std::vector<T>& list) {
    list.resize(json.size());
    for (std::size_t i = 0; i < list.size(); ++i) read(json[i], list[i]);
  }

  template <class T, std::size_t N>
  static void read(const nlohmann::json& json, std::array<T, N>& list) {
    for (std::size_t i = 0; i < N; ++i) read(json[i], list[i]);
  }

  template <class T>
  static void read(const nlohmann::json& json, T& value) {
    if constexpr (std::is_same_v<T, SceneFixed>) value.below.reset();  // a choice in the file replaces the default one
    if constexpr (std::is_same_v<T, ScenePath>) value.press_drag.reset();
    if constexpr (requires(Reader r) { fields(r, value); }) {
      Reader reader(json);
      fields(reader, value);
    } else {
      json.get_to(value);
    }
  }

  const nlohmann::json& json_;
};

/// Every field, but optionals that are not set.
class Writer {
 public:
  template <class T>
  void operator()(const char* key, T& value, const KeyFacts& = {}) {
    json[key] = written(value);
  }

  template <class T>
  void operator()(const char* key, std::optional<T>& value, const KeyFacts& = {}) {
    if (value) json[key] = written(*value);
  }

  Ordered json = Ordered::object();

 private:
  static Ordered written(Vec3& v) { return {v.x(), v.y(), v.z()}; }
  static Ordered written(Waypoint& w) { return {w.t, w.position.x(), w.position.y(), w.position.z()}; }

  template <class T>
  static Ordered written(T& value) {
    using Plain = std::remove_const_t<T>;  // entries of a list come as const
    if constexpr (requires(Writer w, Plain plain) { fields(w, plain); }) {
      Writer writer;
      Plain plain = value;
      fields(writer, plain);
      return writer.json;
    } else if constexpr (requires { value.size(); } && !std::is_same_v<T, std::string>) {
      Ordered list = Ordered::array();
      for (auto& entry : value) list.push_back(written(entry));
      return list;
    } else if constexpr (std::is_same_v<Plain, std::string>) {
      return escape_bytes(value);  // a file's name may be no UTF-8, which JSON is
    } else {
      return value;
    }
  }
};

/// "mu" in the file stands for both coefficients.
void split_mu(nlohmann::json& group) {
  if (group.contains("mu")) group["mu_static"] = group["mu_kinetic"] = group["mu"];
}

void split_all_mu(nlohmann::json& document) {
  if (!document.contains("contact")) return;
  nlohmann::json& contact = document["contact"];
  split_mu(contact);
  if (contact.contains("regions"))
    for (nlohmann::json& region : contact["regions"]) split_mu(region);
}

/// A spring that is given is not calibrated, unless the file asks for it (and find_scene_problem refuses).
void settle_calibrate(nlohmann::json& document) {
  const auto path = nlohmann::json::json_pointer("/object/model");
  if (!document.contains(path)) return;
  nlohmann::json& model = document[path];
  if (model.contains("stiffness") && !model.contains("calibrate")) model["calibrate"] = false;
}

/// A unit by its name is its length in metres.
void settle_unit(nlohmann::json& document, const std::string& group) {
  struct Unit {
    const char* name;
    double metres;
  };
  constexpr Unit kUnits[] = {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};
  const auto path = nlohmann::json::json_pointer("/" + group + "/scale");
  if (!document.contains(path) || !document[path].is_string()) return;
  for (const Unit& unit : kUnits)
    if (document[path] == unit.name) {
      document[path] = unit.metres;
      return;
    }
}

/// A coupling by its name: none is a stiffness of 0, one that is chosen is not given.
void settle_coupling(nlohmann::json& document, const std::string& group) {
  const auto path = nlohmann::json::json_pointer("/" + group + "/path/device");
  if (!document.contains(path) || !document[path].contains("coupling")) return;
  nlohmann::json& device = document[path];
  if (device["coupling"] == "off") device["coupling"] = 0;
  if (device["coupling"] == "auto") device.erase("coupling");
}

/// Self-contact takes steps that are solved to the end, unless the file names others (and the session refuses).
void settle_integrator(nlohmann::json& document) {
  if (!document.contains("global") || !document["global"].contains("self_contact")) return;
  nlohmann::json& global = document["global"];
  if (!global.contains("integrator")) global["integrator"] = "newton_euler";
}

/// contact.law penalty is local.method penalty with Coulomb's cone.
void settle_penalty(nlohmann::json& document) {
  const nlohmann::json::json_pointer law("/contact/law"), method("/local/method");
  if (!document.contains(law) || document[law] != "penalty") return;
  if (document.contains(method) && document[method] != "penalty" && document[method] != "multirate") return;
  document[law] = "coulomb";
  document[method] = "penalty";
}

}  // namespace

Scene scene_from_json(const nlohmann::json& document) {
  nlohmann::json settled = document;
  split_all_mu(settled);
  settle_integrator(settled);
  settle_penalty(settled);
  settle_calibrate(settled);
  for (const char* group : {"object", "tool", "second_tool"}) settle_unit(settled, group);
  for (const char* group : {"tool", "second_tool"}) settle_coupling(settled, group);
  Scene scene;
  scene.is_endless = settled.contains("duration") && settled["duration"].is_null();
  if (scene.is_endless) settled.erase("duration");
  Reader reader(settled);
  fields(reader, scene);
  return scene;
}

std::string to_json(const Scene& scene) {
  Scene copy = scene;  // the field lists serve reading as well, so they take references that are not const
  Writer writer;
  fields(writer, copy);
  if (scene.is_endless) writer.json["duration"] = nullptr;
  return writer.json.dump(2, ' ', false, Ordered::error_handler_t::replace) + "\n";
}

}  // namespace kt
