// Rules between several values, which a schema cannot say.
#include "core/error.hpp"
#include "io/scene_json.hpp"

namespace kt {
namespace {

using Found = std::optional<JsonProblem>;

Found check_object(const SceneObject& object) {
  if (object.fixed.box && ((*object.fixed.box)[1] - (*object.fixed.box)[0]).minCoeff() < 0.0)
    return JsonProblem{"object.fixed.box", "has a max below its min: write [[min x, y, z], [max x, y, z]]"};
  if (object.model.stiffness && object.model.calibrate)
    return JsonProblem{"object.model.calibrate", "is true beside stiffness: a spring is given or calibrated, not both"};
  return std::nullopt;
}

Found check_times(const std::vector<Waypoint>& points, const std::string& path) {
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].t <= points[i - 1].t)
      return JsonProblem{text(path, "[", i, "]"),
                         text("has time ", points[i].t, " s after ", points[i - 1].t, " s: times must increase")};
  return std::nullopt;
}

/// @param name  of the tool in the file
Found check_tool(const SceneTool& tool, const std::string& name) {
  if (tool.shape != "point" && tool.radius <= 0.0)
    return JsonProblem{name + ".radius",
                       text("is 0, must be above 0 for a ", tool.shape, " (or set ", name, ".shape to point)")};
  if (tool.shape == "mesh" && tool.mesh.empty())
    return JsonProblem{name + ".mesh", "is empty: name the file of the mesh tool"};
  if (tool.shape != "mesh" && !tool.mesh.empty())
    return JsonProblem{name + ".mesh", text("is given, but ", name, ".shape is ", tool.shape, ": set it to mesh")};
  const ScenePath& path = tool.path;
  if (path.press_drag && path.press_drag->direction.norm() < 1e-12)
    return JsonProblem{name + ".path.press_drag.direction", "is zero: which way does the tool go?"};
  if (path.waypoints) return check_times(*path.waypoints, name + ".path.waypoints");
  if (path.hand) return check_times(path.hand->target, name + ".path.hand.target");
  return std::nullopt;
}

Found check_contact(const SceneContact& contact) {
  if (contact.mu_kinetic > contact.mu_static)
    return JsonProblem{"contact.mu_kinetic",
                       text("is ", contact.mu_kinetic, ", must be at most mu_static (", contact.mu_static, ")")};
  for (std::size_t i = 0; i < contact.regions.size(); ++i) {
    const SceneRegion& region = contact.regions[i];
    const std::string name = text("contact.regions[", i, "]");
    if ((region.box[1] - region.box[0]).minCoeff() < 0.0)
      return JsonProblem{name + ".box", "has a max below its min: write [[min x, y, z], [max x, y, z]]"};
    if (region.mu_static < 0)
      return JsonProblem{name, "has no friction coefficient: give mu, or mu_static and mu_kinetic"};
    if (region.mu_kinetic > region.mu_static)
      return JsonProblem{name + ".mu_kinetic",
                         text("is ", region.mu_kinetic, ", must be at most mu_static (", region.mu_static, ")")};
  }
  return std::nullopt;
}

Found check_rates(const Scene& scene) {
  const double ticks = scene.duration * scene.local.rate_hz;
  constexpr double kMostTicks = 1e9;  // they are counted in int
  if (!(ticks >= 0.5))
    return JsonProblem{"duration", text("is ", scene.duration, " s, must be at least one tick, ",
                                        1 / scene.local.rate_hz, " s at local.rate_hz ", scene.local.rate_hz)};
  if (!(ticks <= kMostTicks))
    return JsonProblem{"duration", text("is ", scene.duration, " s, must be at most ", kMostTicks, " ticks, ",
                                        kMostTicks / scene.local.rate_hz, " s at local.rate_hz ", scene.local.rate_hz)};
  if (scene.global.rate_hz > scene.local.rate_hz)
    return JsonProblem{"global.rate_hz", text("is ", scene.global.rate_hz, ", must be at most local.rate_hz (",
                                              scene.local.rate_hz, ")")};
  return std::nullopt;
}

}  // namespace

std::optional<JsonProblem> find_scene_problem(const Scene& scene) {
  for (const Found& found : {check_object(scene.object), check_tool(scene.tool, "tool"),
                             scene.second_tool ? check_tool(*scene.second_tool, "second_tool") : Found(),
                             check_contact(scene.contact), check_rates(scene)})
    if (found) return found;
  return std::nullopt;
}

}  // namespace kt
