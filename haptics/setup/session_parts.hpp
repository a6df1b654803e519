#pragma once
// From a scene to what a session is made of: tools, paths, devices, settings of the engine.
#include "haptics/body/body.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/options/touch_options.hpp"

namespace kt {

/// The way that a tool is meant to go; of a hand its target.
struct ToolPath {
  std::vector<TimedPoint> points;
  std::vector<TimedPose> poses;  ///< as many, of a recording with orientations; else empty: tool.turn and tool.spin
};

/// Whether somebody holds one of the tools.
bool is_live(const Scene& scene);

/// Gives a file's bytes; none: the file system.
using ReadFile = std::function<std::string(const std::string& path)>;

/// A path for each tool. Throws InputError for one that no device can follow.
/// @param body  as it is at the start
/// Of a live device one point: where the tool is when the device is opened, unless the scene has its origin.
std::vector<ToolPath> scene_paths(const Scene& scene, std::span<const ToolShape> shapes, const Mesh& body,
                                  std::vector<Finding>& findings);

/// Of a device that somebody holds: opens it. Throws InputError for one that is not there.
/// @param target  of a hand, that another thread moves; none: the path's
std::unique_ptr<HapticDevice> scene_device(const Scene& scene, const SceneTool& tool, const ToolPath& path,
                                           std::shared_ptr<MovedTarget> target = nullptr,
                                           std::shared_ptr<DeviceSlots> pushed = nullptr);

/// The way that a tool took on a device. Its force leaves as it did then, and goes nowhere.
std::unique_ptr<HapticDevice> played_again(const ToolPath& path, const SceneTool& tool, const DeviceInfo& info,
                                           double h);

}  // namespace kt
