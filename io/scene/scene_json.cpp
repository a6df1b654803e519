// One list of fields per struct serves both directions, so what is written is what is read.
#include "io/scene/scene_json.hpp"

#include <nlohmann/json.hpp>

#include "core/base/visible_text.hpp"

namespace kt {
namespace {

using Ordered = nlohmann::ordered_json;  // a saved scene keeps the order of the structs

// clang-format off: one field a line
template <class A>
void fields(A& a, FixedBelow& s) {
  a("axis", s.axis);
  a("fraction", s.fraction);
}
template <class A>
void fields(A& a, SceneFixed& s) {
  a("below", s.below);
  a("box", s.box);
  a("nodes", s.nodes);
}
template <class A>
void fields(A& a, SceneTetrahedralize& s) {
  a("backend", s.backend);
  a("max_volume", s.max_volume);
  a("quality", s.quality);
  a("max_edge", s.max_edge);
}
template <class A>
void fields(A& a, SceneLayers& s) {
  a("count", s.count);
  a("thickness", s.thickness);
}
template <class A>
void fields(A& a, SceneLattice& s) {
  a("edge", s.edge);
  a("nodes", s.nodes);
}
template <class A>
void fields(A& a, SceneDamping& s) {
  a("mass", s.mass);
  a("stiffness", s.stiffness);
  a("law", s.law);
}
template <class A>
void fields(A& a, SceneInclusion& s) {
  a("center", s.center);
  a("radius", s.radius);
  a("stiffer", s.stiffer);
}
template <class A>
void fields(A& a, SceneModel& s) {
  a("type", s.type);
  a("material", s.material);
  a("element", s.element);
  a("consistent_mass", s.consistent_mass);
  a("young", s.young);
  a("poisson", s.poisson);
  a("density", s.density);
  a("damping", s.damping);
  a("stiffness", s.stiffness);
  a("damper", s.damper);
  a("calibrate", s.calibrate);
  a("least_volume", s.least_volume);
  a("inclusions", s.inclusions);
}
template <class A>
void fields(A& a, SceneObject& s) {
  a("mesh", s.mesh);
  a("size", s.size);
  a("scale", s.scale);
  a("repair", s.repair);
  a("body", s.body);
  a("lattice", s.lattice);
  a("fixed", s.fixed);
  a("tetrahedralize", s.tetrahedralize);
  a("layers", s.layers);
  a("gravity", s.gravity);
  a("model", s.model);
}
template <class A>
void fields(A& a, PressDrag& s) {
  a("at", s.at);
  a("depth", s.depth);
  a("press_time", s.press_time);
  a("direction", s.direction);
  a("speed", s.speed);
  a("ease", s.ease);
}
template <class A>
void fields(A& a, SceneHand& s) {
  a("stiffness", s.stiffness);
  a("damping", s.damping);
  a("mass", s.mass);
  a("delay_ms", s.delay_ms);
  a("target", s.target);
}
template <class A>
void fields(A& a, DeviceSettings& s) {
  a("name", s.name);
  a("address", s.address);
  a("id", s.id);
  a("library", s.library);
  a("origin", s.origin);
  a("axes", s.axes);
  a("scale", s.scale);
  a("force_scale", s.force_scale);
  a("max_force", s.max_force);
  a("max_slew", s.max_slew);
  a("damping", s.damping);
  a("delay_ms", s.delay_ms);
  a("coupling", s.coupling);
  a("deadman", s.deadman);
  a("speed", s.speed);
  a("service_damping", s.service_damping);
}
template <class A>
void fields(A& a, ScenePath& s) {
  a("press_drag", s.press_drag);
  a("waypoints", s.waypoints);
  a("recording", s.recording);
  a("hand", s.hand);
  a("device", s.device);
}
template <class A>
void fields(A& a, SceneTool& s) {
  a("shape", s.shape);
  a("radius", s.radius);
  a("length", s.length);
  a("mesh", s.mesh);
  a("size", s.size);
  a("scale", s.scale);
  a("turn", s.turn);
  a("spin", s.spin);
  a("path", s.path);
}
template <class A>
void fields(A& a, PenaltySettings& s) {
  a("stiffness", s.stiffness);
  a("damping", s.damping);
}
template <class A>
void fields(A& a, RegionSettings& s) {
  a("box", s.box);
  a("mu_static", s.mu_static);
  a("mu_kinetic", s.mu_kinetic);
}
template <class A>
void fields(A& a, ContactSettings& s) {
  a("law", s.law);
  a("mu_static", s.mu_static);
  a("mu_kinetic", s.mu_kinetic);
  a("metric", s.metric);
  a("penalty", s.penalty);
  a("stribeck", s.stribeck);
  a("surface", s.surface);
  a("surface_levels", s.surface_levels);
  a("ridge_deg", s.ridge_deg);
  a("regions", s.regions);
}
template <class A>
void fields(A& a, SelfContactSettings& s) {
  a("mu", s.mu);
  a("reach", s.reach);
  a("stiffness", s.stiffness);
  a("creep", s.creep);
}
template <class A>
void fields(A& a, GlobalSettings& s) {
  a("rate_hz", s.rate_hz);
  a("integrator", s.integrator);
  a("solver", s.solver);
  a("tolerance", s.tolerance);
  a("early_refresh", s.early_refresh);
  a("look_ahead", s.look_ahead);
  a("definite", s.definite);
  a("self_contact", s.self_contact);
}
template <class A>
void fields(A& a, LocalSettings& s) {
  a("method", s.method);
  a("rate_hz", s.rate_hz);
  a("reducer", s.reducer);
  a("rings", s.rings);
  a("tolerance", s.tolerance);
  a("budget_us", s.budget_us);
  a("refresh_budget_ms", s.refresh_budget_ms);
  a("catch_up", s.catch_up);
  a("blend_ms", s.blend_ms);
  a("refine", s.refine);
  a("fineness", s.fineness);
  a("refine_nodes", s.refine_nodes);
  a("passivity_damping", s.passivity_damping);
  a("integrator", s.integrator);
}
template <class A>
void fields(A& a, LinkSettings& s) {
  a("type", s.type);
  a("latency_ms", s.latency_ms);
  a("loss", s.loss);
  a("charge_refreshes", s.charge_refreshes);
  a("refresh_ms", s.refresh_ms);
  a("stale_ms", s.stale_ms);
  a("basis_bits", s.basis_bits);
}
template <class A>
void fields(A& a, CollisionSettings& s) {
  a("backend", s.backend);
}
template <class A>
void fields(A& a, Scene& s) {
  a("title", s.title);
  a("duration", s.duration);
  a("seed", s.seed);
  a("object", s.object);
  a("tool", s.tool);
  a("second_tool", s.second_tool);
  a("contact", s.contact);
  a("global", s.global);
  a("local", s.local);
  a("link", s.link);
  a("collision", s.collision);
}
// clang-format on

/// Takes the fields that the document has.
class Reader {
 public:
  explicit Reader(const nlohmann::json& json) : json_(json) {}

  template <class T>
  void operator()(const char* key, T& value) const {
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
  void operator()(const char* key, T& value) {
    json[key] = written(value);
  }

  template <class T>
  void operator()(const char* key, std::optional<T>& value) {
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
