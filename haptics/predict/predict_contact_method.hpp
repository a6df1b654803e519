#pragma once
// Contact methods that look too seldom, or push too hard, for the tool's speed: what lets a tool through, and chatter.
#include <optional>

#include "haptics/predict/predict.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// How the scripted tool moves where it meets the body at rest.
struct ToolMeeting {
  double speed = 0;      ///< fastest, where it goes through the surface [m/s]
  double drag = 0;       ///< fastest at all, once it has touched [m/s]
  double thickness = 0;  ///< of the body along the way in, at the thinnest; infinity: it does not come out again [m]
  double mass = 0;       ///< least of a surface node near the way [kg]
};

/// Nothing for a path that does not reach the surface, or that is no list of points.
std::optional<ToolMeeting> find_meeting(const BuiltScene& built);

/// None for the engine's own method, which follows the tool along its way.
std::optional<Prediction> predict_tunnelling(const Scene& scene, const ToolMeeting& meeting);
std::optional<Prediction> predict_chatter(const Scene& scene, const ToolMeeting& meeting);

}  // namespace kt
