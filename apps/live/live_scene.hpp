#pragma once
// A scene whose first tool a device is given by the command line.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// @param others  that the command knows besides live devices. @throws InputError: no such device
void check_live_device(const std::string& name, std::vector<std::string> others);

/// The scene with its first tool on a live device, when one is named; of several the one with that id.
Scene with_live_device(Scene scene, const std::string& name, const std::string& id = {});

/// A tool that somebody holds.
struct LiveTool {
  std::string name;  ///< "tool", "second_tool"
  DeviceSettings* device;
};
std::vector<LiveTool> live_tools(Scene& scene);

/// Of a scene that goes to, or comes from, another computer: of each device its name alone stays. Library, address,
/// limits, slew and coupling are the business of whoever holds it.
void forget_device_settings(Scene& scene);

}  // namespace kt
