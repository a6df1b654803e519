// Rules between several values, which a schema cannot say.
#include <cmath>

#include "core/base/error.hpp"
#include "io/scene/scene_json.hpp"

namespace kt {
namespace {

using Found = std::optional<JsonProblem>;

constexpr double kFarthest = 1e6;  // [m] of a tool's path
constexpr double kLargest = 1e9;   // of a component of any other vector: its square and its length stay finite

Found check_range(double value, double most, const std::string& path) {
  if (std::abs(value) <= most) return std::nullopt;
  return JsonProblem{path, text("is ", value, ", must be at least ", -most, ", at most ", most)};
}

Found check_vector(const Vec3& v, const std::string& path) {
  for (int c = 0; c < 3; ++c)
    if (const Found found = check_range(v[c], kLargest, text(path, "[", c, "]"))) return found;
  return std::nullopt;
}

Found check_box(const std::array<Vec3, 2>& box, const std::string& path) {
  for (std::size_t i = 0; i < 2; ++i)
    if (const Found found = check_vector(box[i], text(path, "[", i, "]"))) return found;
  return std::nullopt;
}

Found check_object(const SceneObject& object) {
  if (object.fixed.box)
    if (const Found found = check_box(*object.fixed.box, "object.fixed.box")) return found;
  if (const Found found = check_vector(object.gravity, "object.gravity")) return found;
  for (std::size_t i = 0; i < object.model.inclusions.size(); ++i)
    if (const Found found =
            check_vector(object.model.inclusions[i].center, text("object.model.inclusions[", i, "].center")))
      return found;
  if (object.fixed.box && ((*object.fixed.box)[1] - (*object.fixed.box)[0]).minCoeff() < 0.0)
    return JsonProblem{"object.fixed.box", "has a max below its min: write [[min x, y, z], [max x, y, z]]"};
  if (object.model.stiffness && object.model.calibrate)
    return JsonProblem{"object.model.calibrate", "is true beside stiffness: a spring is given or calibrated, not both"};
  if (object.model.type == "msd" && !object.model.stiffness && !object.model.calibrate)
    return JsonProblem{"object.model.calibrate",
                       "is false without stiffness: give object.model.stiffness (N/m, of every spring), or leave "
                       "calibrate out to have it from young"};
  return std::nullopt;
}

Found check_times(const std::vector<Waypoint>& points, const std::string& path) {
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 4; ++k)
      if (const Found found = check_range(k == 0 ? points[i].t : points[i].position[k - 1], kFarthest,
                                          text(path, "[", i, "][", k, "]")))
        return found;
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
  if (const Found found = check_vector(tool.turn, name + ".turn")) return found;
  if (const Found found = check_vector(tool.spin, name + ".spin")) return found;
  const ScenePath& path = tool.path;
  if (path.press_drag) {
    const std::string drag = name + ".path.press_drag";
    if (const Found found = check_vector(path.press_drag->direction, drag + ".direction")) return found;
    for (std::size_t k = 0; path.press_drag->at && k < 2; ++k)
      if (const Found found = check_range((*path.press_drag->at)[k], kFarthest, text(drag, ".at[", k, "]")))
        return found;
  }
  if (path.press_drag && path.press_drag->direction.norm() < 1e-12)
    return JsonProblem{name + ".path.press_drag.direction", "is zero: which way does the tool go?"};
  if (path.waypoints) return check_times(*path.waypoints, name + ".path.waypoints");
  if (path.hand) return check_times(path.hand->target, name + ".path.hand.target");
  if (path.device && path.device->origin) return check_vector(*path.device->origin, name + ".path.device.origin");
  return std::nullopt;
}

Found check_contact(const ContactSettings& contact) {
  if (contact.mu_kinetic > contact.mu_static)
    return JsonProblem{"contact.mu_kinetic",
                       text("is ", contact.mu_kinetic, ", must be at most mu_static (", contact.mu_static, ")")};
  for (std::size_t i = 0; i < contact.regions.size(); ++i) {
    const RegionSettings& region = contact.regions[i];
    const std::string name = text("contact.regions[", i, "]");
    if (const Found found = check_box(region.box, name + ".box")) return found;
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

Found check_law(const Scene& scene) {
  if (scene.contact.law != "penalty") return std::nullopt;
  return JsonProblem{"contact.law", text("penalty is a method of its own; local.method \"", scene.local.method,
                                         "\" needs contact.law \"coulomb\", or leave local.method out")};
}

Found check_link(const LinkSettings& link) {
  if (link.basis_bits != 8 && link.basis_bits != 16)
    return JsonProblem{"link.basis_bits", text("is ", link.basis_bits, ", must be 8 or 16")};
  if (link.charge_refreshes == "given" && !link.refresh_ms)
    return JsonProblem{"link.charge_refreshes", "is given without link.refresh_ms: say what a refresh takes (ms)"};
  if (link.charge_refreshes != "given" && link.refresh_ms)
    return JsonProblem{"link.refresh_ms",
                       text("is given, but link.charge_refreshes is ", link.charge_refreshes, ": set it to given")};
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
  for (const Found& found :
       {check_object(scene.object), check_tool(scene.tool, "tool"),
        scene.second_tool ? check_tool(*scene.second_tool, "second_tool") : Found(), check_contact(scene.contact),
        check_law(scene), check_link(scene.link), check_rates(scene)})
    if (found) return found;
  return std::nullopt;
}

}  // namespace kt
