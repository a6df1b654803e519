// From a scene to what a session is made of: tools, paths, devices, settings of the engine.
#include <cmath>

#include "collision/held/moving_tool.hpp"
#include "haptics/device/device_backends.hpp"
#include "haptics/device/press_drag.hpp"
#include "haptics/device/recording.hpp"
#include "haptics/driver/device_frame.hpp"
#include "haptics/link/links.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/setup/session_parts.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

/// A mesh about the middle of its bounding box.
/// @param name  of the tool in the scene
ToolShape scene_mesh_tool(const SceneTool& tool, const std::string& name, const ReadFile& read_file) {
  Mesh mesh = load_mesh(tool.mesh, {.read_file = read_file});
  mesh.x *= tool.scale.value_or(1);
  const Bounds box = bounds(mesh);
  const double longest = box.size().maxCoeff();
  if (!(longest > 0)) throw InputError(text(name, ".mesh: ", tool.mesh, ": all nodes lie on one point"));
  const double scale = tool.size ? *tool.size / longest : 1;
  for (int i = 0; i < mesh.num_nodes(); ++i) node(mesh.x, i) = scale * (node(mesh.x, i) - box.centre());
  return make_mesh_tool(mesh, tool.radius);
}

ToolShape scene_tool(const SceneTool& tool, const std::string& name, const ReadFile& read_file) {
  if (tool.shape == "point") return {ToolShape::Kind::point, 0};
  if (tool.shape == "sphere") return {ToolShape::Kind::sphere, tool.radius};
  if (tool.shape == "capsule") return make_capsule(tool.radius, tool.length);
  if (tool.shape == "mesh") return scene_mesh_tool(tool, name, read_file);
  throw_unknown(name + ".shape", tool.shape, {"point", "sphere", "capsule", "mesh"});
}

std::vector<TimedPoint> to_path(const std::vector<Waypoint>& waypoints) {
  std::vector<TimedPoint> out;
  for (const Waypoint& w : waypoints) out.push_back({w.t, w.position});
  return out;
}

int pressing_axis(const SceneFixed& fixed) { return fixed.below ? fixed.below->axis[0] - 'x' : 2; }

/// How near the reference points of two tools may come before the tools overlap, as far as their radii tell [m].
double least_apart(std::span<const ToolShape> tools) {
  constexpr double kLeast = 1e-6;  // of points
  return std::max(kLeast, tools[0].radius + tools[1].radius);
}

PressDragOptions press_drag_options(const PressDrag& p, const SceneTool& tool, const Scene& scene) {
  PressDragOptions out;
  out.axis = pressing_axis(scene.object.fixed);
  out.at = p.at;
  out.depth = p.depth;
  out.press_time = p.press_time;
  out.direction = p.direction;
  out.speed = p.speed;
  out.duration = scene.duration;
  out.clearance = 0.5 * p.depth;
  out.turn = rotation(tool.turn);
  out.eased = p.ease == "minimum_jerk";
  return out;
}

/// Above the middle of the body [m], clear of it.
Vec3 over_the_middle(const Mesh& body, int axis, double radius) {
  constexpr double kClear = 0.1;  // of the body's extent
  const Bounds box = bounds(body);
  Vec3 out = box.centre();
  out[axis] += 0.5 * box.size()[axis] + radius + kClear * box.size().maxCoeff();
  return out;
}

/// @param name   of the tool in the scene
/// @param other  path of a tool from which a place that is chosen stays `apart` [m]
ToolPath scene_path(const Scene& scene, const SceneTool& tool, const std::string& name, const ToolShape& shape,
                    const Mesh& body, std::vector<Finding>& findings, const std::vector<TimedPoint>& other = {},
                    double apart = 0) {
  const ScenePath& p = tool.path;
  if (p.recording) {
    Recording recording = read_recording(*p.recording, 1 / scene.local.rate_hz);
    for (const std::string& note : recording.notes)
      findings.push_back({text(name, ".path.recording ", *p.recording, ": ", note)});
    if (!recording.poses.empty() && !(tool.turn.isZero(0) && tool.spin.isZero(0)))
      findings.push_back(
          {text(name, ".turn and ", name, ".spin do nothing: ", *p.recording, " has the tool's orientation"),
           {},
           Finding::Weight::note});
    return {std::move(recording.path), std::move(recording.poses)};
  }
  if (p.press_drag) {
    PressDragOptions options = press_drag_options(*p.press_drag, tool, scene);
    options.other = other;
    options.apart = apart;
    return {make_press_drag(body, shape, options), {}};
  }
  if (p.waypoints) return {to_path(*p.waypoints), {}};
  if (p.device) {
    require_backend(name + ".path.device.name", p.device->name, live_device_backends());
    device_axes(p.device->axes);
    return {{{0, over_the_middle(body, pressing_axis(scene.object.fixed), shape.radius)}}, {}};
  }
  return {p.hand ? to_path(p.hand->target) : std::vector<TimedPoint>(), {}};
}

/// A wrong path is found now and not by run(). A device that somebody holds is opened when the run begins.
void try_device(const Scene& scene, const SceneTool& tool, const ToolPath& path) {
  if (!tool.path.device) scene_device(scene, tool, path);
}

/// Tools pass through one another unseen: where they do so all the time, one lies in the other's place.
void check_apart(const std::vector<TimedPoint>& first, const std::vector<TimedPoint>& second, double apart,
                 std::vector<Finding>& findings) {
  const double start = (first.front().x - second.front().x).norm(), least = least_distance(first, second);
  const auto say = [&](const char* when, double distance) {
    return text("second_tool.path: the tools are ", 1e3 * distance, " mm apart ", when, ", their radii together are ",
                1e3 * apart, " mm: they do not touch one another, and both push the same piece of the body");
  };
  if (start < apart) throw InputError(say("at the start", start) + "; move one");
  if (least < apart) findings.push_back({say("on their way", least), {advise("move one")}});
}

}  // namespace

std::vector<BackendInfo> link_backends() {
  return {
#define LINK(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/link/link.def"
  };
}

std::unique_ptr<HapticDevice> scene_device(const Scene& scene, const SceneTool& tool, const ToolPath& path,
                                           std::shared_ptr<MovedTarget> target, std::shared_ptr<DeviceSlots> pushed) {
  const ScenePath& p = tool.path;
  DeviceOptions options;
  options.h = 1 / scene.local.rate_hz;
  options.path = path.points;
  options.poses = path.poses;
  options.turn = {tool.turn, tool.spin};
  if (p.device) {
    options.live = *p.device;
    options.over = path.points.front().x;
    options.slots = std::move(pushed);
    return make_device(p.device->name, options);
  }
  if (p.recording) return make_device("recorded", options);
  if (!p.hand) return make_device("scripted", options);
  options.hand_stiffness = p.hand->stiffness;
  options.hand_damping = p.hand->damping;
  options.hand_mass = p.hand->mass;
  options.hand_delay = 1e-3 * p.hand->delay_ms;
  options.target = std::move(target);
  return make_device("hand", options);
}

std::unique_ptr<HapticDevice> played_again(const ToolPath& path, const SceneTool& tool, const DeviceInfo& info,
                                           double h) {
  DeviceOptions options;
  options.path = path.points;
  options.poses = path.poses;
  options.turn = {tool.turn, tool.spin};
  options.h = h;
  options.info = info;
  return make_device("recorded", options);
}

std::vector<ToolPath> scene_paths(const Scene& scene, std::span<const ToolShape> shapes, const Mesh& body,
                                  std::vector<Finding>& findings) {
  std::vector<ToolPath> out{scene_path(scene, scene.tool, "tool", shapes[0], body, findings)};
  try_device(scene, scene.tool, out[0]);
  if (!scene.second_tool) return out;
  const double apart = least_apart(shapes);
  out.push_back(
      scene_path(scene, *scene.second_tool, "second_tool", shapes[1], body, findings, out[0].points, 2 * apart));
  try_device(scene, *scene.second_tool, out[1]);
  check_apart(out[0].points, out[1].points, apart, findings);
  return out;
}

bool is_live(const Scene& scene) {
  return scene.tool.path.device || (scene.second_tool && scene.second_tool->path.device);
}

BodyOptions body_options(const Scene& scene, ReadFile read_file) {
  return {scene.object, scene.global, scene.contact.ridge_deg, scene.collision.backend, std::move(read_file)};
}

TouchOptions touch_options(const Scene& scene, const ReadFile& read_file) {
  require_backend("object.model.type", scene.object.model.type, model_backends());
  require_backend("object.model.material", scene.object.model.material, material_backends());
  if (const auto& tetrahedra = scene.object.tetrahedralize; tetrahedra && !tetrahedra->backend.empty())
    require_backend("object.tetrahedralize.backend", tetrahedra->backend, tetrahedralizers());
  require_backend("link.type", scene.link.type, link_backends());
  if (scene.global.self_contact && scene.global.integrator != "newton_euler")
    throw InputError(text("global.integrator \"", scene.global.integrator,
                          "\" steps through a body's contacts with itself; global.self_contact needs newton_euler (the "
                          "default beside it)"));
  TouchOptions out;
  out.tools.front().shape = scene_tool(scene.tool, "tool", read_file);
  if (scene.second_tool) out.tools.emplace_back().shape = scene_tool(*scene.second_tool, "second_tool", read_file);
  out.contact = scene.contact;
  out.global = scene.global;
  out.local = scene.local;
  if (out.local.method == "legacy" && out.local.reducer == "auto") out.local.reducer = "wall";  // it knows no other
  out.link = scene.link;
  out.collision = scene.collision;
  out.seed = scene.seed;
  check_options(out);
  return out;
}

}  // namespace kt
