#pragma once
// From a tool's path.device in a scene to its safety chain.
#include "haptics/guard/safety_chain.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// Buttons of which one has to be held: "none" is 0, "any" all, "1" the first.
unsigned button_mask(const std::string& deadman);

/// The device's own info is filled in by whoever has it. Of a device that somebody holds the controller is always on.
SafetyOptions safety_options(const Scene& scene, const SceneTool& tool);

}  // namespace kt
