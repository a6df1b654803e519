#include "haptics/driver/haply_messages.hpp"

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

/// The first of the grips, of whichever kind.
void read_grip(const json& all, HaplyState& out) {
  for (const char* kind : {"wireless_verse_grip", "verse_grip", "custom_verse_grip"}) {
    const json* const grips = member(all, kind);
    if (!grips || !grips->is_array() || grips->empty()) continue;
    const json& grip = grips->front();
    if (const auto turn = quaternion(member(grip, "state", "orientation"))) out.turn = turn;
    if (const json* const buttons = member(grip, "state", "buttons")) {
      unsigned bit = 0;
      for (const char* name : {"a", "b", "c"}) {
        const json* const button = member(*buttons, name);
        if (button && button->is_boolean() && button->get<bool>()) out.buttons |= 1u << bit;
        ++bit;
      }
    }
    if (const json* const button = member(grip, "state", "button"); button && button->is_boolean())
      out.buttons |= button->get<bool>();
    return;
  }
}

json with_device(const std::string& id) { return {{"inverse3", json::array({{{"device_id", id}}})}}; }

json force_json(const double (&force)[3]) {
  return {{"set_cursor_force", {{"values", {{"x", force[0]}, {"y", force[1]}, {"z", force[2]}}}}}};
}

}  // namespace

HaplyState read_haply_state(const std::string& message, const std::string& id) {
  const json all = json::parse(message, nullptr, false);
  if (!all.is_object()) throw InputError("haply: the service sent what is no JSON object");
  HaplyState out;
  const json* const devices = member(all, "inverse3");
  if (devices && devices->is_array())
    for (const json& device : *devices) {
      const std::string its = word(member(device, "device_id"));
      if (its.empty()) continue;
      out.devices.push_back(its);
      out.models.push_back(word(member(device, "config", "device_info")));
      if (out.models.back().empty())
        if (const json* const info = member(device, "config", "device_info"))
          out.models.back() = word(member(*info, "model"));
      if (!(id.empty() ? out.devices.size() == 1 : its == id)) continue;
      out.x = vector(member(device, "state", "cursor_position"));
      out.v = vector(member(device, "state", "cursor_velocity"));
      out.force = vector(member(device, "state", "current_cursor_force"));
      if (const json* const calibrated = member(device, "status", "calibrated"); calibrated && calibrated->is_boolean())
        out.is_calibrated = calibrated->get<bool>();
    }
  read_grip(all, out);
  return out;
}

std::string haply_greeting(const std::string& id, double service_damping) {
  json out = with_device(id);
  out["session"]["configure"] = {{"profile", {{"name", "org.kilotouch"}}}, {"basis", {{"permutation", "XYZ"}}}};
  out["inverse3"][0]["configure"] = {{"damping", {{"scalar", service_damping}}}, {"force_gate", {{"gain", 0.0}}}};
  const double none[3] = {0, 0, 0};
  out["inverse3"][0]["commands"] = force_json(none);
  return out.dump();
}

std::string haply_force(const std::string& id, const double (&force)[3]) {
  json out = with_device(id);
  out["inverse3"][0]["commands"] = force_json(force);
  return out.dump();
}

std::string haply_question() { return json{{"session", {{"force_render_full_state", json::object()}}}}.dump(); }

}  // namespace kt
