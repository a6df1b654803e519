#include "api/held_touch.hpp"

#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/guard/device_words.hpp"
#include "haptics/setup/scene_safety.hpp"
#include "haptics/watch/tick_words.hpp"

namespace kt {
namespace {

/// Of a device that the caller has.
SafetyOptions options_of_chain(const Scene& scene, SceneTool tool) {
  if (!tool.path.device) tool.path.device.emplace();
  SafetyOptions out = safety_options(scene, tool);
  out.device.is_live = out.device.yields = out.device.gives_torque = true;
  return out;
}

std::shared_ptr<const Body> without_self_contact(std::shared_ptr<const Body> body) {
  if (body->self_contact())
    throw InputError("body: it has self-contact, which one touch at a time can use; make a body for each touch");
  return body;
}

}  // namespace

HeldTouch::HeldTouch(const Scene& scene, const std::function<Body()>& make_body)
    : HeldTouch(scene, touch_options(scene),
                [&] { return std::make_shared<const Body>(make_body ? make_body() : Body(body_options(scene))); }) {}

HeldTouch::HeldTouch(const Scene& scene, std::shared_ptr<const Body> shared)
    : HeldTouch(scene, touch_options(scene), [&] { return without_self_contact(std::move(shared)); }) {}

HeldTouch::HeldTouch(const Scene& scene, const TouchOptions& options, const BodyMaker& make)
    : held_(make()), body(*held_), touch(body, options) {
  safety_.push_back(options_of_chain(scene, scene.tool));
  if (scene.second_tool) safety_.push_back(options_of_chain(scene, *scene.second_tool));
  for (const SafetyOptions& options_of_one : safety_) chains_.emplace_back(options_of_one);
}

void HeldTouch::reset(const TouchState* state) {
  state ? touch.reset(*state) : touch.reset();
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

std::vector<Finding> HeldTouch::findings() const {
  constexpr double kNoticeableShare = 0.01;  // of the ticks, as of a run's
  std::vector<Finding> out = touch.findings();
  for (std::size_t k = 0; k < chains_.size(); ++k) {
    const SafetyCounts& s = chains_[k].counts();
    const auto of_all = [&](int count) { return text(count, " of ", s.ticks, " ticks"); };
    const auto add = [&](const std::string& words, int count, double limit = 0) {
      out.push_back(Finding{which(k) + words}.at(tool_key(k), count, limit));
    };
    if (never_opened(s) || s.shut > 0) add(gate_words(s), never_opened(s) ? s.ticks : s.shut);
    if (s.limited > 0) add(limited_words(s.limited), s.limited);
    if (s.slewed > kNoticeableShare * s.ticks)
      add(slewed_words(of_all(s.slewed)), s.slewed, kNoticeableShare * s.ticks);
    if (s.stale > 0) add(stale_pose_words(of_all(s.stale)), s.stale);
    if (s.jumps > 0) add(leap_words(s.jumps), s.jumps);
    if (s.not_finite > 0)
      add(text("the force was no number in ", of_all(s.not_finite), ": none was given"), s.not_finite);
  }
  return out;
}

Body body_of_mesh(Mesh mesh, const Scene& scene) {
  return Body(filled(std::move(mesh), scene.object), body_options(scene));
}

}  // namespace kt
