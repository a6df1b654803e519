#include "api/held_touch.hpp"

#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/setup/scene_safety.hpp"

namespace kt {
namespace {

/// Of a device that the caller has.
SafetyOptions options_of_chain(const Scene& scene, SceneTool tool) {
  if (!tool.path.device) tool.path.device.emplace();
  SafetyOptions out = safety_options(scene, tool);
  out.device.is_live = out.device.yields = out.device.gives_torque = true;
  return out;
}

}  // namespace

HeldTouch::HeldTouch(const Scene& scene, const std::function<Body()>& make_body)
    : HeldTouch(scene, touch_options(scene), make_body) {}

HeldTouch::HeldTouch(const Scene& scene, const TouchOptions& options, const std::function<Body()>& make_body)
    : body(make_body ? make_body() : Body(body_options(scene))), touch(body, options) {
  safety_.push_back(options_of_chain(scene, scene.tool));
  if (scene.second_tool) safety_.push_back(options_of_chain(scene, *scene.second_tool));
  for (const SafetyOptions& options_of_one : safety_) chains_.emplace_back(options_of_one);
}

void HeldTouch::reset() {
  touch.reset();
  chains_.clear();
  for (const SafetyOptions& options : safety_) chains_.emplace_back(options);
}

std::span<const LocalFrame> HeldTouch::tick_devices(std::span<const Pose> devices, std::span<const DeviceState> states,
                                                    double dt) noexcept {
  constexpr double kLongest = 1;  // [s] more than that says no more of speeds
  dt = std::min(dt, kLongest);
  std::array<Pose, kMaxTools> to;
  for (std::size_t k = 0; k < devices.size(); ++k) to[k] = chains_[k].tool(devices[k], dt);
  const std::span<const LocalFrame> frames = touch.tick(std::span<const Pose>(to.data(), devices.size()));
  for (std::size_t k = 0; k < devices.size(); ++k) {
    given_[k] = frames[k];
    const Wrench out = chains_[k].make_safe(given_[k], devices[k], states[k], dt);
    given_[k].force = out.force;
    given_[k].torque = out.torque;
  }
  return {given_.data(), devices.size()};
}

std::vector<std::string> HeldTouch::warnings() const {
  std::vector<std::string> out = touch.warnings();
  for (std::size_t k = 0; k < chains_.size(); ++k) {
    const SafetyCounts& s = chains_[k].counts();
    const std::string which = chains_.size() > 1 ? text("tool ", k + 1, ": ") : "";
    const GateReason why = main_reason(s);
    const bool never_opened = s.ticks > 0 && s.gated == s.ticks;
    if (never_opened || s.shut > 0)
      out.push_back(text(which, "the device's gate ",
                         never_opened ? "never opened fully"
                                      : text("was shut or not fully open in ", s.gated, " of ", s.ticks, " ticks"),
                         why == GateReason::open ? "" : text(": mostly because ", name_of(why))));
    if (s.stale > 0)
      out.push_back(text(which, "the device's pose was too old, or the device not there, in ", s.stale, " of ", s.ticks,
                         " ticks"));
    if (s.jumps > 0)
      out.push_back(text(which, "the device's pose leapt ", s.jumps, s.jumps == 1 ? " time" : " times",
                         " as no hand moves: it was not followed"));
    if (s.not_finite > 0)
      out.push_back(
          text(which, "the force was no number in ", s.not_finite, " of ", s.ticks, " ticks: none was given"));
  }
  return out;
}

Body body_of_mesh(Mesh mesh, const Scene& scene) {
  return Body(filled(std::move(mesh), scene.object), body_options(scene));
}

}  // namespace kt
