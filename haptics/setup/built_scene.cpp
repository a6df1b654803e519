#include "haptics/setup/built_scene.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "haptics/contact/scene_friction.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/setup/tool_unit.hpp"
#include "haptics/setup/unused_settings.hpp"

namespace kt {
namespace {

/// Below, a stiff contact is felt as steps and swings in the hand (Colgate and Schenkel 1997); above, a tick's own work
/// does not fit, and no device takes its forces. Choi and Tan (2004) ask for 5 to 10 kHz where textures are to be
/// clean.
void warn_of_rate(double rate_hz, std::vector<std::string>& notes) {
  constexpr double kLeast = 250, kMost = 10000;
  if (rate_hz < kLeast)
    notes.push_back(text("local.rate_hz is ", rate_hz, ": below ", kLeast,
                         " Hz a hand feels the steps of the force, and a stiff contact swings; usual are 1000 Hz"));
  if (rate_hz > kMost)
    notes.push_back(text("local.rate_hz is ", rate_hz, ": above ", kMost, " Hz a tick has less than ", 1e6 / kMost,
                         " us, and no device takes forces as fast; textures need 5000 to 10000 Hz"));
}

}  // namespace

// In braces, in order: what is wrong with a setting is told before the mesh is filled.
BuiltScene::BuiltScene(const Scene& scene, std::shared_ptr<SceneFiles> files)
    : BuiltScene{scene, touch_options(scene, keeping_reader(files)), Body(body_options(scene, keeping_reader(files))),
                 files} {}

BuiltScene::BuiltScene(const Scene& scene, SceneFiles files)
    : BuiltScene(scene, std::make_shared<SceneFiles>(std::move(files))) {}

BuiltScene::BuiltScene(const Scene& scene, Mesh body)
    : BuiltScene{scene, touch_options(scene), Body(std::move(body), body_options(scene)),
                 std::make_shared<SceneFiles>()} {}

BuiltScene::BuiltScene(const Scene& scene, std::unique_ptr<DeformableModel> model)
    : BuiltScene{scene, touch_options(scene), Body(std::move(model), body_options(scene)),
                 std::make_shared<SceneFiles>()} {
  SceneObject unset;
  unset.mesh = scene.object.mesh;
  if (scene.object == unset) return;
  findings_.push_back(
      {"object: its material, clamped part, weight and size do nothing: the body is a model of one's own",
       {},
       Finding::Weight::note});
}

BuiltScene::BuiltScene(const Scene& scene, TouchOptions options, Body body, std::shared_ptr<SceneFiles> files)
    : scene_(scene),
      files_(std::move(files)),
      options_(std::move(options)),
      body_(std::move(body)),
      tools_(shapes_of(options_)) {
  const double longest = bounds(body_.model().mesh()).size().maxCoeff();
  require_tool_unit(scene_.tool, "tool", sides_of(tools_[0]), longest);
  if (scene_.second_tool) require_tool_unit(*scene_.second_tool, "second_tool", sides_of(tools_[1]), longest);
  scene_.local = options_.local;
  if (is_live(scene_) && scene_.link.type == "lockstep")
    scene_.link.type = options_.link.type = "thread";  // a refresh in a tick would stall the device
  std::ranges::move(unused_settings(scene_), std::back_inserter(findings_));
  std::vector<std::string> notes;
  warn_of_rate(scene_.local.rate_hz, notes);
  friction_ = scene_friction(scene_.contact, body_.surface(), body_.model().mesh().x, notes);
  for (std::string& note : notes) findings_.push_back({std::move(note), {}, Finding::Weight::note});
  std::ranges::copy(body_.findings(), std::back_inserter(findings_));
  Mesh hanging = body_.model().mesh();
  hanging.x = body_.start().x;
  paths_ = scene_paths(scene_, tools_, hanging, findings_);
}

void BuiltScene::take(Course course) {
  scene_.tool.path = std::move(course.path);
  paths_[0] = std::move(course.points);
  scene_.duration = course.duration;
  scene_.is_endless = course.is_endless;
}

void BuiltScene::follow(std::vector<TimedPoint> path) {
  constexpr double kFarthest = 1e6;  // [m], as places in a scene
  if (path.empty() || !(path.back().t > 0)) throw InputError("tool.path: takes no time");
  for (std::size_t i = 0; i < path.size(); ++i)
    if (!(path[i].x.lpNorm<Eigen::Infinity>() <= kFarthest))
      throw InputError(text("tool.path: point ", i, " is not within ", kFarthest, " m"));
  std::vector<Waypoint> waypoints;
  for (const TimedPoint& p : path) waypoints.push_back({p.t, p.x});
  scene_.tool.path = {.press_drag = {}, .waypoints = std::move(waypoints), .recording = {}, .hand = {}, .device = {}};
  last(path.back().t);
  paths_[0] = {std::move(path), {}};
  scene_device(scene_, scene_.tool, paths_[0]);  // a wrong path is found now and not by run()
}

void BuiltScene::hold() {
  const ToolPath& path = paths_[0];
  const Vec3 start = path.poses.empty() ? path.points.front().x : path.poses.front().pose.x;
  SceneHand hand = scene_.tool.path.hand.value_or(SceneHand{});
  if (!scene_.tool.path.hand)
    hand.damping = 2 * std::sqrt(hand.stiffness * hand.mass);  // critical: nobody is there to damp it
  hand.target = {{0, start}, {1, start}};
  scene_.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = std::move(hand), .device = {}};
  paths_[0] = {{{0, start}, {1, start}}, {}};
}

}  // namespace kt
