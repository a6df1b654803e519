#include "haptics/setup/scene_safety.hpp"

namespace kt {
namespace {

constexpr double kLiveDamping = 20;  // [N s/m] that the controller may add: docs/stability_haptics.md

}  // namespace

unsigned button_mask(const std::string& deadman) {
  if (deadman == "none") return 0;
  return deadman == "any" ? ~0u : 1u << (deadman[0] - '1');
}

SafetyOptions safety_options(const Scene& scene, const SceneTool& tool) {
  SafetyOptions out;
  out.h = 1 / scene.local.rate_hz;
  out.most_damping = scene.local.passivity_damping;
  out.fades_when_stale = scene.link.type == "network";
  if (!tool.path.device) return out;
  const DeviceSettings& device = *tool.path.device;
  if (!(out.most_damping > 0)) out.most_damping = kLiveDamping;
  out.scale = device.scale;
  out.force_scale = device.force_scale;
  out.max_force = device.max_force;
  out.max_slew = device.max_slew;
  out.deadman = button_mask(device.deadman);
  out.damping = device.damping;
  if (device.delay_ms) out.delay = 1e-3 * *device.delay_ms;
  out.coupling = device.coupling;
  return out;
}

}  // namespace kt
