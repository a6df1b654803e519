#include "apps/live/live_scene.hpp"

#include <algorithm>

#include "core/base/backend.hpp"
#include "core/base/error.hpp"
#include "haptics/device/device_backends.hpp"
#include "haptics/device/haptic_device.hpp"

namespace kt {

void check_live_device(const std::string& name, std::vector<std::string> others) {
  for (const BackendInfo& live : live_device_backends())
    if (live.name != "pushed") others.push_back(live.name);
  if (std::ranges::find(others, name) == others.end()) throw_unknown("device", name, others);
}

Scene with_live_device(Scene scene, const std::string& name, const std::string& id) {
  if (name == "pointer") return scene;  // the page's run puts its hand there
  const auto live = live_device_backends();
  if (std::ranges::find(live, name, &BackendInfo::name) == live.end()) return scene;
  DeviceSettings settings;
  settings.name = name;
  if (scene.tool.path.device && scene.tool.path.device->name == name) settings = *scene.tool.path.device;
  if (!id.empty()) settings.id = id;
  scene.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = {}, .device = settings};
  return scene;
}

std::vector<LiveTool> live_tools(Scene& scene) {
  std::vector<LiveTool> out;
  if (scene.tool.path.device) out.push_back({"tool", &*scene.tool.path.device});
  if (scene.second_tool && scene.second_tool->path.device)
    out.push_back({"second_tool", &*scene.second_tool->path.device});
  return out;
}

void forget_device_settings(Scene& scene) {
  for (const LiveTool& tool : live_tools(scene)) {
    DeviceSettings plain;
    plain.name = tool.device->name;
    *tool.device = plain;
  }
}

}  // namespace kt
