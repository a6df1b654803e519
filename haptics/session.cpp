#include "haptics/session.hpp"

#include <cmath>
#include <numbers>

#include "collision/moving_tool.hpp"
#include "core/step_solver.hpp"
#include "haptics/device/press_drag.hpp"
#include "haptics/device/recording.hpp"
#include "haptics/links.hpp"
#include "haptics/metrics.hpp"
#include "haptics/path_excitation.hpp"
#include "haptics/real_time.hpp"
#include "haptics/refresh_cost.hpp"
#include "haptics/scene_friction.hpp"
#include "haptics/session_run.hpp"
#include "haptics/tool_turn.hpp"
#include "haptics/unused_settings.hpp"
#include "io/mesh_io.hpp"
#include "io/tetrahedralize.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"
#include "self_contact/crossings.hpp"

namespace kt {
namespace {

/// A mesh about the middle of its bounding box.
/// @param name  of the tool in the scene
ToolShape scene_mesh_tool(const SceneTool& tool, const std::string& name) {
  Mesh mesh = load_mesh(tool.mesh);
  mesh.x *= tool.scale.value_or(1);
  const Bounds box = bounds(mesh);
  const double longest = box.size().maxCoeff();
  if (!(longest > 0)) throw InputError(text(name, ".mesh: ", tool.mesh, ": all nodes lie on one point"));
  const double scale = tool.size ? *tool.size / longest : 1;
  for (int i = 0; i < mesh.num_nodes(); ++i) node(mesh.x, i) = scale * (node(mesh.x, i) - box.centre());
  return make_mesh_tool(mesh, tool.radius);
}

ToolShape scene_tool(const SceneTool& tool, const std::string& name) {
  if (tool.shape == "point") return {ToolShape::Kind::point, 0};
  if (tool.shape == "sphere") return {ToolShape::Kind::sphere, tool.radius};
  if (tool.shape == "capsule") return make_capsule(tool.radius, tool.length);
  if (tool.shape == "mesh") return scene_mesh_tool(tool, name);
  throw_unknown(name + ".shape", tool.shape, {"point", "sphere", "capsule", "mesh"});
}

std::vector<ToolShape> scene_tools(const Scene& scene) {
  std::vector<ToolShape> out{scene_tool(scene.tool, "tool")};
  if (scene.second_tool) out.push_back(scene_tool(*scene.second_tool, "second_tool"));
  return out;
}

ModelOptions model_options(const SceneObject& object, const std::vector<int>& fixed_nodes) {
  const SceneModel& m = object.model;
  ModelOptions out;
  out.young = m.young;
  out.poisson = m.poisson;
  out.density = m.density;
  out.damping_mass = m.damping.mass;
  out.damping_stiffness = m.damping.stiffness;
  out.stiffness = m.stiffness;
  out.damper = m.damper;
  out.least_volume = m.least_volume;
  out.material = m.material;
  out.element = m.element;
  out.consistent_mass = m.consistent_mass;
  out.rayleigh = m.damping.law == "rayleigh";
  out.gravity = object.gravity;
  for (const SceneInclusion& i : m.inclusions) out.inclusions.push_back({i.center, i.radius, i.stiffer});
  out.fixed_nodes = fixed_nodes;
  return out;
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

/// @param name   of the tool in the scene
/// @param other  path of a tool from which a place that is chosen stays `apart` [m]
std::vector<TimedPoint> scene_path(const Scene& scene, const SceneTool& tool, const std::string& name,
                                   const ToolShape& shape, const Mesh& body, std::vector<std::string>& warnings,
                                   const std::vector<TimedPoint>& other = {}, double apart = 0) {
  const ScenePath& p = tool.path;
  if (p.recording) {
    Recording recording = read_recording(*p.recording, 1 / scene.local.rate_hz);
    for (const std::string& note : recording.notes)
      warnings.push_back(text(name, ".path.recording ", *p.recording, ": ", note));
    return std::move(recording.path);
  }
  if (p.press_drag) {
    PressDragOptions options = press_drag_options(*p.press_drag, tool, scene);
    options.other = other;
    options.apart = apart;
    return make_press_drag(body, shape, options);
  }
  if (p.waypoints) return to_path(*p.waypoints);
  return p.hand ? to_path(p.hand->target) : std::vector<TimedPoint>();
}

/// Tools pass through one another unseen: where they do so all the time, one lies in the other's place.
void check_apart(const std::vector<TimedPoint>& first, const std::vector<TimedPoint>& second, double apart,
                 std::vector<std::string>& warnings) {
  const double start = (first.front().x - second.front().x).norm(), least = least_distance(first, second);
  const auto say = [&](const char* when, double distance) {
    return text("second_tool.path: the tools are ", 1e3 * distance, " mm apart ", when, ", their radii together are ",
                1e3 * apart, " mm: they do not touch one another, and both push the same piece of the body; move one");
  };
  if (start < apart) throw InputError(say("at the start", start));
  if (least < apart) warnings.push_back(say("on their way", least));
}

std::unique_ptr<HapticDevice> scene_device(const Scene& scene, const SceneTool& tool,
                                           const std::vector<TimedPoint>& path) {
  const ScenePath& p = tool.path;
  DeviceOptions options;
  options.h = 1 / scene.local.rate_hz;
  options.path = path;
  if (p.recording) return make_device("recorded", options);
  if (!p.hand) return make_device("scripted", options);
  options.hand_stiffness = p.hand->stiffness;
  options.hand_damping = p.hand->damping;
  options.hand_mass = p.hand->mass;
  options.hand_delay = 1e-3 * p.hand->delay_ms;
  return make_device("hand", options);
}

/// The way that a tool took on a device. Its force leaves as it did then, and goes nowhere.
std::unique_ptr<HapticDevice> played_again(const std::vector<TimedPoint>& path, const DeviceLimits& limits, double h) {
  DeviceOptions options;
  options.path = path;
  options.h = h;
  options.limits = limits;
  return make_device("recorded", options);
}

/// Names and combinations that only the tables of several libraries together can judge.
void check_methods(const Scene& scene) {
  require_backend("object.model.type", scene.object.model.type, model_backends());
  require_backend("object.model.material", scene.object.model.material, material_backends());
  if (const auto& tetrahedra = scene.object.tetrahedralize; tetrahedra && !tetrahedra->backend.empty())
    require_backend("object.tetrahedralize.backend", tetrahedra->backend, tetrahedralizers());
  require_backend("link.type", scene.link.type, link_backends());
  require_backend("collision.backend", scene.collision.backend, triangle_index_backends());
  require_backend("local.reducer", scene.local.reducer, reducer_names());
  require_backend("global.integrator", scene.global.integrator, integrator_backends());
  require_backend("global.solver", scene.global.solver, step_solver_backends());
  require_backend("contact.law", scene.contact.law, contact_laws());
  if (scene.global.self_contact && scene.global.integrator != "newton_euler")
    throw InputError(text("global.integrator \"", scene.global.integrator,
                          "\" steps through a body's contacts with itself; global.self_contact needs newton_euler (the "
                          "default beside it)"));
  if (local_scheme(scene.local.integrator) == LocalScheme::exact && is_geometric(scene.contact.law))
    throw InputError(text("local.integrator \"exact\" is none of the paper's; contact.law \"", scene.contact.law,
                          "\" needs symplectic_euler or implicit_euler"));
  make_scene_method(scene, std::vector<ToolShape>(1));
  scene_smoothing(scene);
  const bool is_round = scene.tool.shape == "point" || scene.tool.shape == "sphere";
  const std::string method = haptic_method_name(scene.local.method, scene.contact.law);
  if (scene.second_tool && (method != "multirate" || is_geometric(scene.contact.law)))
    throw InputError(text("second_tool: contact.law \"", scene.contact.law, "\" with local.method \"",
                          scene.local.method,
                          "\" knows one tool; two need local.method multirate with contact.law coulomb"));
  if (!is_round && (is_geometric(scene.contact.law) || method == "frozen" || method == "penalty" || method == "legacy"))
    throw InputError(
        text("tool.shape \"", scene.tool.shape, "\": contact.law \"", scene.contact.law, "\" with local.method \"",
             scene.local.method,
             "\" knows a point and a sphere; take local.method multirate or hold with contact.law coulomb"));
  if (scene.local.method == "legacy" && scene.local.reducer != "wall")
    throw InputError(text("local.method \"legacy\" is a framework with a wall: it needs local.reducer \"wall\", not \"",
                          scene.local.reducer, "\""));
  if (!is_geometric(scene.contact.law) && contact_metric(scene.contact.metric) == Metric::identity)
    throw InputError(
        text("contact.metric \"identity\" belongs to the paper's laws (its operators are projectors in "
             "positions); contact.law \"",
             scene.contact.law, "\" needs \"mass\" or \"implicit\""));
}

Scene checked(Scene scene) {
  if (scene.local.method == "legacy" && scene.local.reducer == "auto")
    scene.local.reducer = "wall";  // it knows no other
  check_methods(scene);
  return scene;
}

/// The wall clock does not wait for a body that takes longer than its interval.
void warn_of_lag(const Scene& scene, SessionResult& result) {
  const double seconds = static_cast<double>(result.frames.size()) / scene.local.rate_hz;
  const double reached = static_cast<double>(result.global_ms.size()) / seconds;
  if (reached >= 0.8 * scene.global.rate_hz) return;
  const RealTime r = judge_real_time(scene, result);
  result.warnings.push_back(text("the body was refreshed at ", reached, " Hz of global.rate_hz ", scene.global.rate_hz,
                                 ": ", r.slow_part, " takes ", r.part_ms, " of the ", r.refresh_ms,
                                 " ms of a refresh; ", r.cure));
  result.notes.push_back(result.warnings.back());
}

/// What a patch is not made for; the path of a device that yields is known when it is over.
/// @param h  haptic step [s]
void warn_of_speed(const std::vector<LocalFrame>& frames, const Vec3& start, double h, const std::string& who,
                   std::vector<std::string>& warnings) {
  int count = 0;
  std::size_t fastest = 0;
  double most = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double speed = (frames[i].tool - (i > 0 ? frames[i - 1].tool : start)).norm() / h;
    count += speed > kFollowedSpeed;
    if (speed <= most) continue;
    most = speed;
    fastest = i;
  }
  if (count > 0)
    warnings.push_back(text(who, "too fast in ", count, " of ", frames.size(), " ticks, most of all in tick ", fastest,
                            " (t = ", frames[fastest].t, " s) with ", most, " m/s, ", most * h,
                            " m in one tick: local models are made for up to ", kFollowedSpeed,
                            " m/s, contact beyond is coarse; give the path more time there"));
}

/// What a limit cycle feeds on. Pressing at rest the hold gives next to nothing.
void warn_of_activity(const std::optional<PassivityRun>& energy, SessionResult& result) {
  constexpr double kShare = 0.5;  // of the largest energy that the hand had put in
  if (!energy) return;
  const PassivityRun& p = *energy;
  if (p.least < -kShare * p.most || p.most_debt > kShare * p.most)
    result.warnings.push_back(
        text("the haptic loop gave the hand energy: holding the force over a tick gave ", 1e3 * p.most_debt,
             " mJ that nothing took back, the hand had put in ", 1e3 * p.most,
             " mJ at most: expect a limit cycle; raise tool.path.hand.damping or local.rate_hz, or "
             "set local.passivity_damping"));
}

/// A body that lies on itself has no equilibrium to solve for until it does: it falls, in long steps, which are damped.
State settled_by_falling(const Scene& scene, const DeformableModel& model, SelfContact& contact,
                         std::vector<std::string>& warnings) {
  constexpr int kMostSteps = 100;
  constexpr double kStep = 0.03;  // [s]
  TouchingEuler integrator(contact, {.solver = scene.global.solver, .tolerance = scene.global.tolerance});
  State state = rest_state(model);
  const VectorX none = VectorX::Zero(state.x.size());
  double speed = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    state.v.setZero();  // what it has fallen it has lost: only where it lies counts
    integrator.step(model, none, kStep, state);
    speed = state.v.lpNorm<Eigen::Infinity>();
    if (speed <= 0.01 * contact.options.creep) break;
  }
  if (speed > contact.options.creep)
    warnings.push_back(text("object.gravity: after ", kMostSteps * kStep, " s the body still moves, at up to ", speed,
                            " m/s; it starts where it is then, at rest"));
  return {0, state.x, none};
}

/// Why a state is none that a body can hang in; empty when it is one.
std::string collapse(const DeformableModel& model, const VectorX& x) {
  constexpr double kMost = 1;  // of the body's longest extent: a rod bends through a right angle with less
  const Mesh& mesh = model.mesh();
  const auto inside_out =
      std::ranges::count_if(mesh.tetrahedra, [&](const Tetrahedron& t) { return tetrahedron_volume(x, t) < 0; });
  const double sag = (x - mesh.x).reshaped(3, mesh.num_nodes()).colwise().norm().maxCoeff();
  const double size = bounds(mesh).size().maxCoeff();
  if (inside_out == 0 && sag < kMost * size) return {};
  return text("it would sag by ", 1e3 * sag, " mm, ", sag / size, " of its size, with ", inside_out, " of ",
              mesh.tetrahedra.size(), " tetrahedra inside out");
}

/// The setting that holds a body up, and about how far it has to be raised.
std::string stiffer(const SceneObject& object, const Mesh& mesh) {
  constexpr double kShortened = 0.1;  // a column of this stiffness, by its own weight: rho g H / (2 E)
  const SceneModel& m = object.model;
  if (m.type == "msd" && m.stiffness) return text("raise object.model.stiffness (", *m.stiffness, " N/m)");
  const double height = bounds(mesh).size().dot(object.gravity.cwiseAbs()) / object.gravity.norm();
  const double enough = m.density * object.gravity.norm() * height / (2 * kShortened);
  return text("raise object.model.young (", m.young, " Pa) to about ", std::max(enough, 3 * m.young), " Pa");
}

/// A body with weight has hung in it before the session; without a clamped part it falls.
State settled(const Scene& scene, const DeformableModel& model, SelfContact* self_contact,
              std::vector<std::string>& warnings) {
  State state = rest_state(model);
  const SceneObject& object = scene.object;
  if (object.gravity.isZero(0) || model.fixed_nodes().empty()) return state;
  std::string why;
  if (self_contact) {
    state = settled_by_falling(scene, model, *self_contact, warnings);
    why = collapse(model, state.x);
  } else {
    const auto equilibrium = make_integrator("quasistatic", {.solver = scene.global.solver});
    try {
      equilibrium->step(model, VectorX::Zero(state.x.size()), 0, state);
      why = equilibrium->statistics().not_converged > 0 ? "no equilibrium was found" : collapse(model, state.x);
    } catch (const RunError&) {
      why = "no equilibrium was found";
    }
  }
  if (why.empty()) return state;
  warnings.push_back(text("object.gravity: the body does not bear its own weight: ", why,
                          "; it starts undeformed and falls; ", stiffer(object, model.mesh()),
                          ", lower object.gravity, or clamp more of it (object.fixed)"));
  return rest_state(model);
}

}  // namespace

std::vector<BackendInfo> link_backends() {
  return {
#define LINK(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/link/link.def"
#undef LINK
  };
}

Session::Session(const Scene& scene) : scene_(checked(scene)), tools_(scene_tools(scene)) {
  build(load_scene_mesh(scene, warnings_, &mesh_unit_));
}

Session::Session(const Scene& scene, Mesh body) : scene_(checked(scene)), tools_(scene_tools(scene)) {
  build(std::move(body));
}

void Session::build(Mesh mesh) {
  const Scene& scene = scene_;
  for (std::string& setting : unused_settings(scene)) warnings_.push_back(std::move(setting));
  const std::vector<int> fixed = find_fixed_nodes(mesh, scene.object.fixed);
  if (fixed.empty()) warnings_.push_back("object.fixed: nothing is clamped, the body floats");
  model_ = make_model(scene.object.model.type, std::move(mesh), model_options(scene.object, fixed));
  surface_ = make_surface(model_->mesh(), scene_.contact.ridge_deg * std::numbers::pi / 180);
  if (scene.global.self_contact) set_up_self_contact();
  friction_ = scene_friction(scene.contact, surface_, model_->mesh().x, warnings_);
  notes_ = warnings_;
  start_ = settled(scene, *model_, self_contact_.get(), warnings_);
  Mesh hanging = model_->mesh();
  hanging.x = start_.x;
  path_ = scene_path(scene, scene.tool, "tool", tools_[0], hanging, warnings_);
  scene_device(scene, scene.tool, path_);  // a wrong path is found now and not by run()
  if (scene.second_tool) {
    const double apart = least_apart(tools_);
    second_path_ =
        scene_path(scene, *scene.second_tool, "second_tool", tools_[1], hanging, warnings_, path_, 2 * apart);
    scene_device(scene, *scene.second_tool, second_path_);
    check_apart(path_, second_path_, apart, warnings_);
  }
  predictions_ = predict_failures(*this);
  for (const Prediction& known : predictions_) warnings_.push_back(known.message);
}

void Session::set_up_self_contact() {
  const SceneSelfContact& s = *scene_.global.self_contact;
  self_contact_ = std::make_unique<SelfContact>(*model_, SelfContactOptions{.reach = s.reach.value_or(0),
                                                                            .stiffness = s.stiffness.value_or(0),
                                                                            .mu = s.mu,
                                                                            .creep = s.creep,
                                                                            .backend = scene_.collision.backend});
  const auto found = find_crossings(*self_contact_, surface_.triangles, model_->mesh().x);
  if (found.empty()) return;
  const Crossing& first = found.front();
  throw InputError(text("global.self_contact: ", scene_.object.mesh,
                        ": the surface crosses or touches itself at the start in ", found.size(),
                        found.size() == 1 ? " pair" : " pairs", " of triangles: first at (", first.at.x(), ", ",
                        first.at.y(), ", ", first.at.z(), "), triangles ", first.triangles[0], " ", first.triangles[1],
                        "; move the pieces apart"));
}

void Session::follow(std::vector<TimedPoint> path) {
  if (path.empty() || !(path.back().t > 0)) throw InputError("tool.path: takes no time");
  std::vector<Waypoint> waypoints;
  for (const TimedPoint& p : path) waypoints.push_back({p.t, p.x});
  scene_.tool.path = {.press_drag = {}, .waypoints = std::move(waypoints), .recording = {}, .hand = {}};
  scene_.duration = path.back().t;
  path_ = std::move(path);
  scene_device(scene_, scene_.tool, path_);  // a wrong path is found now and not by run()
}

Session::~Session() = default;

namespace {

SelfContactRun summarize(const SelfContact& contact, const Refresher& refresher) {
  SelfContactRun out{.extremes = {}, .reach = contact.options.reach, .stiffness = contact.options.stiffness};
  if (refresher.look_for_crossings) out.crossings = refresher.crossings;
  out.extremes.nearest = std::numeric_limits<double>::infinity();
  const auto steps = std::max(1.0, static_cast<double>(refresher.self_contacts.size()));
  for (const SelfContactReport& r : refresher.self_contacts) {
    out.extremes.contacts = std::max(out.extremes.contacts, r.contacts);
    out.extremes.nearest = std::min(out.extremes.nearest, r.nearest);
    out.extremes.normal = std::max(out.extremes.normal, r.normal);
    out.extremes.energy = std::max(out.extremes.energy, r.energy);
    out.mean_normal += r.normal / steps;
    out.touching_share += r.contacts > 0;
  }
  out.touching_share /= steps;
  return out;
}

}  // namespace

/// Of both tools' paths, of a hand that of its target. As a ball: a longer tool asks for no other rates.
std::optional<BandPowers> Session::followed_motion() const {
  if (scene_.local.reducer != "auto") return {};
  const double use = (1 + (models_come_late(scene_) ? 1 : 0)) / scene_.global.rate_hz + 1e-3 * scene_.link.latency_ms;
  const auto powers = [&](const std::vector<TimedPoint>& path, const ToolShape& tool) {
    return path_powers(path, FollowedMotion(surface_, start_.x, tool.radius, scene_.contact.mu_static),
                       scene_.local.rate_hz, use);
  };
  BandPowers out = powers(path_, tools_[0]);
  if (scene_.second_tool) {
    const BandPowers second = powers(second_path_, tools_[1]);
    out.total += second.total;
    for (std::size_t i = 0; i < kBands; ++i) out.changing[i] += second.changing[i];
  }
  if (!(out.total > 0)) return {};
  return out;
}

SessionResult Session::run(const SessionOptions& options) {
  SessionResult result;
  result.warnings = warnings_;
  result.notes = notes_;
  const SessionOptions& used = options;
  const bool threaded = scene_.link.type == "thread" && options.refreshes.empty();

  std::vector<std::unique_ptr<HapticDevice>> devices;
  devices.push_back(scene_device(scene_, scene_.tool, path_));
  if (scene_.second_tool) devices.push_back(scene_device(scene_, *scene_.second_tool, second_path_));
  for (std::size_t k = 0; k < std::min(devices.size(), options.tool_paths.size()); ++k)
    devices[k] = played_again(options.tool_paths[k], devices[k]->limits(), 1 / scene_.local.rate_hz);
  result.max_speed = options.max_speed > 0 ? options.max_speed : devices[0]->max_speed();
  std::vector<ReachingTool> reaching{{tools_[0], result.max_speed}};
  if (scene_.second_tool) {
    SecondToolRun& second = result.second_tool.emplace();
    second.max_speed = options.second_max_speed > 0 ? options.second_max_speed : devices[1]->max_speed();
    reaching.push_back({tools_[1], second.max_speed});
  }
  Refresher refresher(*model_, surface_, scene_, std::move(reaching), start_, self_contact_.get(), followed_motion());
  if (options.reducer_changes) refresher.follow(*options.reducer_changes);
  refresher.look_for_crossings = used.check_contacts && !threaded;
  HapticLoop haptic(scene_, tools_, friction_, std::move(devices), used, surface_, threaded);
  const int ticks = std::max(1, static_cast<int>(std::llround(scene_.local.rate_hz / scene_.global.rate_hz)));
  const RunParts parts{scene_, tools_, friction_, used, refresher, haptic, result, ticks};
  threaded ? run_threads(parts) : run_lockstep(parts);
  haptic.finish(result);
  result.global_ms = std::move(refresher.global_ms);
  result.refresh_ms = std::move(refresher.refresh_ms);
  result.refresh_parts_ms = {{"linearize", std::move(refresher.linearize_ms)},
                             {"reduce", std::move(refresher.reduce_ms)},
                             {"certify", std::move(refresher.certify_ms)},
                             {"prepare", std::move(refresher.prepare_ms)}};
  result.reducer = refresher.choice().chosen().reducer;
  result.reducer_name = refresher.choice().chosen().name;
  result.reducer_reason = refresher.choice().reason();
  result.reducer_candidates = refresher.choice().candidates();
  result.reducer_changes = refresher.choice().changes();
  result.expected_force_error = refresher.choice().force_error();
  result.refresh_budget_ms = refresh_budget_ms(scene_);
  result.certified_error = refresher.choice().certified_error();
  result.damping_coupling = refresher.coupling;
  result.exact_steps = refresher.exact_steps;
  result.linearization_error = std::move(refresher.linearization_error);
  if (threaded) warn_of_lag(scene_, result);
  warn_of_speed(result.frames, result.start, 1 / scene_.local.rate_hz, "tool.path: ", result.warnings);
  if (result.second_tool)
    warn_of_speed(result.second_tool->frames, result.second_tool->start, 1 / scene_.local.rate_hz,
                  "second_tool.path: ", result.warnings);
  warn_of_activity(result.passivity, result);
  if (result.second_tool) warn_of_activity(result.second_tool->passivity, result);
  if (self_contact_) result.self_contact = summarize(*self_contact_, refresher);
  result.definite_tangents = refresher.definite_tangents;
  result.looked_ahead = refresher.looked_ahead;
  result.global_steps = refresher.statistics();
  result.inverted = refresher.inverted;
  if (result.inverted.most > 0)
    result.warnings.push_back(
        text(result.inverted.most, " of ", model_->mesh().tetrahedra.size(),
             " tetrahedra turned inside out, first at t = ", result.inverted.from,
             result.inverted.last > 0 ? text(" s, and ", result.inverted.last, " are at the end") : " s, and came back",
             ": forces from then on are not to be trusted; press less deep, or refine the mesh"));
  return result;
}

}  // namespace kt
