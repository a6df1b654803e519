#include "haptics/driver/haply/haply_messages.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace kt {
namespace {

using nlohmann::json;

const json* member(const json& group, const char* key) {
  if (!group.is_object()) return nullptr;
  const auto at = group.find(key);
  return at == group.end() ? nullptr : &*at;
}

/// "state.cursor_position"
const json* member(const json& group, const char* first, const char* second) {
  const json* const inner = member(group, first);
  return inner ? member(*inner, second) : nullptr;
}

std::optional<double> finite(const json& group, const char* key) {
  const json* const value = member(group, key);
  if (!value || !value->is_number() || !std::isfinite(value->get<double>())) return {};
  return value->get<double>();
}

std::optional<Vec3> vector(const json* group) {
  if (!group) return {};
  const auto x = finite(*group, "x"), y = finite(*group, "y"), z = finite(*group, "z");
  if (!x || !y || !z) return {};
  return Vec3(*x, *y, *z);
}

std::optional<Quaternion> quaternion(const json* group) {
  if (!group) return {};
  const auto w = finite(*group, "w");
  const auto v = vector(group);
  if (!w || !v) return {};
  const Quaternion out(*w, v->x(), v->y(), v->z());
  constexpr double kUnit = 0.1;  // apart from one: rounding, not a turn
  if (!(std::abs(out.norm() - 1) < kUnit)) return {};
  return out.normalized();
}

std::string word(const json* value) { return value && value->is_string() ? value->get<std::string>() : std::string(); }

bool flag(const json& group, const char* key, bool usual) {
  const json* const value = member(group, "status", key);
  return value && value->is_boolean() ? value->get<bool>() : usual;
}

HaplyStatus read_status(const json& device) {
  return {.has_power = flag(device, "power_supply", true),
          .is_calibrated = flag(device, "calibrated", true),
          .is_ready = flag(device, "ready", true),
          .is_started = flag(device, "started", true),
          .is_in_use = flag(device, "in_use", false)};
}

std::string read_type(const json& device) {
  if (const std::string type = word(member(device, "config", "type")); !type.empty()) return type;
  const json* const info = member(device, "config", "device_info");
  return info ? (info->is_string() ? word(info) : word(member(*info, "model"))) : std::string();
}

/// "NAME 1 2 3" of a vector that is there and is another one; else nothing. What equals the identity may be left out.
std::string other_vector(const json& group, const char* key, const Vec3& ours, const std::string& name) {
  constexpr double kRounding = 1e-6;
  const auto value = vector(member(group, key));
  if (!value || (*value - ours).norm() <= kRounding) return {};
  return text(name, " ", value->x(), " ", value->y(), " ", value->z());
}

std::string other_transform(const json* group, const std::string& name) {
  if (!group) return {};
  const json* const inner = member(*group, "transform");  // commands wrap it, snapshots do not
  const json& t = inner ? *inner : *group;
  if (auto out = other_vector(t, "scale", Vec3::Ones(), name + ".scale"); !out.empty()) return out;
  constexpr double kAngle = 1e-4;  // [rad]
  if (const auto r = quaternion(member(t, "rotation")); r && r->angularDistance(Quaternion::Identity()) > kAngle)
    return text(name, ".rotation ", r->w(), " ", r->x(), " ", r->y(), " ", r->z());
  return other_vector(t, "position", Vec3::Zero(), name + ".position");
}

/// "+XY+Z" is "XYZ".
std::string permutation(const json* basis) {
  std::string out = basis ? word(basis->is_string() ? basis : member(*basis, "permutation")) : std::string();
  std::erase(out, '+');
  return out;
}

/// What of a device's configuration is not what we ask for.
std::string read_altered(const json& device, const json& config) {
  if (auto out = other_transform(member(config, "mount"), "mount"); !out.empty()) return out;
  if (auto out = other_transform(member(device, "state", "transform"), "transform"); !out.empty()) return out;
  if (const std::string axes = permutation(member(config, "basis")); !axes.empty() && axes != "XYZ")
    return "basis " + axes;
  const json* const given = member(config, "preset");
  const std::string preset = given && given->is_object() ? word(member(*given, "preset")) : word(given);
  if (!preset.empty() && preset != "defaults" && preset != "custom") return "preset " + preset;
  if (const json* const gate = member(config, "filters", "force_gate"))
    if (const auto gain = finite(*gate, "gain"); gain && *gain != 0) return text("filters.force_gate.gain ", *gain);
  return {};
}

constexpr const char* kGripKinds[] = {"wireless_verse_grip", "verse_grip", "custom_verse_grip"};

/// Each grip of the message: f(kind, grip, its id).
template <class F>
void for_each_grip(const json& all, F f) {
  for (const char* kind : kGripKinds)
    if (const json* const grips = member(all, kind); grips && grips->is_array())
      for (const json& grip : *grips) f(kind, grip, text(kind, " ", word(member(grip, "device_id"))));
}

constexpr int kDeepest = 12;  // of what is searched: no message is nested as deep

/// Whether a key of `group`, however deep, that speaks of a partner names `id`.
bool names_partner(const json& group, const std::string& id, bool is_of_partner = false, int depth = 0) {
  if (depth > kDeepest) return false;
  if (group.is_string()) return is_of_partner && group.get<std::string>() == id;
  if (group.is_array())
    return std::ranges::any_of(group,
                               [&](const json& inner) { return names_partner(inner, id, is_of_partner, depth + 1); });
  if (!group.is_object()) return false;
  for (const auto& [key, inner] : group.items()) {
    const bool speaks = key.find("pair") != std::string::npos || key.find("grip") != std::string::npos ||
                        key.find("inverse") != std::string::npos;
    if (names_partner(inner, id, is_of_partner || speaks, depth + 1)) return true;
  }
  return false;
}

/// The grip that is paired with the device; without a word of pairs the only one.
std::string choose_grip(const json& all, const json& device, std::size_t& count) {
  const std::string id = word(member(device, "device_id"));
  std::string paired, only;
  for_each_grip(all, [&](const char*, const json& grip, const std::string& name) {
    ++count;
    only = count == 1 ? name : std::string();
    const std::string its = word(member(grip, "device_id"));
    if (paired.empty() && ((!its.empty() && names_partner(device, its)) || (!id.empty() && names_partner(grip, id))))
      paired = name;
  });
  return paired.empty() ? only : paired;
}

void read_grip(const json& all, const std::string& chosen, HaplyState& out) {
  for_each_grip(all, [&](const char*, const json& grip, const std::string& name) {
    if (name != chosen) return;
    if (const auto turn = quaternion(member(grip, "state", "orientation"))) out.turn = turn;
    if (const json* const buttons = member(grip, "state", "buttons")) {
      unsigned bit = 0;
      for (const char* button_name : {"a", "b", "c"}) {
        const json* const button = member(*buttons, button_name);
        if (button && button->is_boolean() && button->get<bool>()) out.buttons |= 1u << bit;
        ++bit;
      }
    }
    if (const json* const button = member(grip, "state", "button"); button && button->is_boolean())
      out.buttons |= button->get<bool>();
  });
}

void read_device(const json& all, const json& device, HaplyState& out) {
  out.status = read_status(device);
  out.x = vector(member(device, "state", "cursor_position"));
  out.v = vector(member(device, "state", "cursor_velocity"));
  out.force = vector(member(device, "state", "current_cursor_force"));
  const json* const config = member(device, "config");
  if (!config || !config->is_object()) return;
  out.is_full = true;
  out.altered = read_altered(device, *config);
  out.grip = choose_grip(all, device, out.grips);
  for (const char* key : {"type", "mount", "preset", "basis", "filters"})
    if (member(*config, key)) out.key = HaplyKey::vector;
}

json with_device(const std::string& id) { return {{"inverse3", json::array({{{"device_id", id}}})}}; }

json force_json(const double (&force)[3], HaplyKey key) {
  return {{"set_cursor_force", {{name_of(key), {{"x", force[0]}, {"y", force[1]}, {"z", force[2]}}}}}};
}

json identity_json() {
  const json zero = {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}, one = {{"x", 1.0}, {"y", 1.0}, {"z", 1.0}};
  return {{"transform",
           {{"position", zero}, {"rotation", {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}}}, {"scale", one}}}};
}

json session_json() { return {{"profile", {{"name", "org.kilotouch"}}}, {"basis", {{"permutation", "XYZ"}}}}; }

json filters_json(double service_damping) {
  return {{"damping", {{"scalar", service_damping}}}, {"force_gate", {{"gain", 0.0}}}};
}

std::optional<double> number(const json& value, int depth = 0) {
  if (value.is_number() && std::isfinite(value.get<double>())) return value.get<double>();
  for (const char* key : {"value", "data"})
    if (const json* const inner = member(value, key))
      if (const auto out = depth < kDeepest ? number(*inner, depth + 1) : std::nullopt) return out;
  return {};
}

/// `key` as it is, or one part of it inside the other.
std::optional<double> find_setting(const json& group, const std::string& key, int depth = 0) {
  if (depth > kDeepest) return {};
  if (group.is_array()) {
    for (const json& one : group) {
      if (word(member(one, "key")) == key || word(member(one, "name")) == key) return number(one);
      if (const auto out = find_setting(one, key, depth + 1)) return out;
    }
    return {};
  }
  if (!group.is_object()) return {};
  for (const auto& [name, inner] : group.items()) {
    if (name == key) return number(inner);
    const bool is_folder = key.starts_with(name + "/");
    if (const auto out = find_setting(inner, is_folder ? key.substr(name.size() + 1) : key, depth + 1)) return out;
  }
  return {};
}

}  // namespace

const char* name_of(HaplyKey key) noexcept { return key == HaplyKey::vector ? "vector" : "values"; }

HaplyState read_haply_state(const std::string& message, const std::string& id, const std::string& grip) {
  const json all = json::parse(message, nullptr, false);
  if (!all.is_object()) throw InputError("haply: the service sent what is no JSON object");
  HaplyState out;
  const json* const devices = member(all, "inverse3");
  out.has_list = devices && devices->is_array();
  if (out.has_list)
    for (const json& device : *devices) {
      const std::string its = word(member(device, "device_id"));
      if (its.empty()) continue;
      out.devices.push_back({its, read_type(device), read_status(device)});
      if (id.empty() ? out.devices.size() == 1 : its == id) read_device(all, device, out);
    }
  read_grip(all, grip.empty() ? out.grip : grip, out);
  return out;
}

std::string haply_name(const std::string& type) {
  if (type.empty() || type == "inverse3") return "Inverse3";
  if (type == "inverse3x") return "Inverse3x";
  return type == "minverse" ? "Minverse" : type;
}

double haply_reach(const std::string& type) noexcept { return type == "minverse" ? 0.04 : 0.1; }

std::string haply_greeting(const std::string& id, double service_damping, HaplyKey key) {
  json out = with_device(id);
  out["session"]["configure"] = session_json();
  json& device = out["inverse3"][0];
  device["configure"] = filters_json(service_damping);
  device["configure"]["preset"] = {{"preset", "defaults"}};
  const double none[3] = {0, 0, 0};
  device["commands"] = force_json(none, key);
  return out.dump();
}

std::string haply_identities(const std::string& id, double service_damping) {
  json out = with_device(id);
  out["session"] = {{"configure", session_json()}, {"force_render_full_state", json::object()}};
  json& device = out["inverse3"][0];
  device["configure"] = filters_json(service_damping);
  device["configure"]["mount"] = identity_json();
  device["commands"]["set_transform"] = identity_json();
  return out.dump();
}

std::string haply_force(const std::string& id, const double (&force)[3], HaplyKey key) {
  json out = with_device(id);
  out["inverse3"][0]["commands"] = force_json(force, key);
  return out.dump();
}

std::string haply_question(const std::string& id, bool is_full) {
  json out = json::object();
  if (is_full) out["session"]["force_render_full_state"] = json::object();
  if (!id.empty()) {
    out["inverse3"] = with_device(id)["inverse3"];
    out["inverse3"][0]["commands"]["probe_position"] = json::object();
  }
  return out.dump();
}

std::optional<double> read_haply_setting(const std::string& answer, const std::string& key) {
  const json all = json::parse(answer, nullptr, false);
  if (all.is_discarded()) return {};
  if (const auto out = find_setting(all, key)) return out;
  return number(all);  // the answer to a single key
}

HaplyEvent read_haply_event(const std::string& message) {
  const json all = json::parse(message, nullptr, false);
  if (!all.is_object()) throw InputError("haply: the service sent an event that is no JSON object");
  return {.name = word(member(all, "name")),
          .level = word(member(all, "level")),
          .device = word(member(all, "data", "device_id")),
          .kind = word(member(all, "data", "safety_type")),
          .message = word(member(all, "message"))};
}

}  // namespace kt
