#include "haptics/session.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ranges>

#include "haptics/metrics.hpp"
#include "haptics/path_excitation.hpp"
#include "haptics/real_time.hpp"
#include "haptics/refresh_cost.hpp"
#include "haptics/refresher.hpp"
#include "haptics/scene_friction.hpp"
#include "haptics/session_run.hpp"
#include "haptics/unused_settings.hpp"

namespace kt {
namespace {

/// The wall clock does not wait for a body that takes longer than its interval.
void warn_of_lag(const Scene& scene, SessionResult& result) {
  const double seconds = static_cast<double>(result.tools[0].frames.size()) / scene.local.rate_hz;
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
void warn_of_speed(const ToolRun& run, double h, const std::string& who, std::vector<std::string>& warnings) {
  const std::vector<LocalFrame>& frames = run.frames;
  int count = 0;
  std::size_t fastest = 0;
  double most = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double speed = (frames[i].pose.x - (i > 0 ? frames[i - 1].pose.x : run.start.x)).norm() / h;
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

/// Whoever watches is told of the end, however it comes.
class Watched {
 public:
  Watched(SessionWatcher* watcher, Touch& touch) : watcher_(watcher) {
    if (watcher_) watcher_->begun(touch);
  }
  ~Watched() {
    if (watcher_) watcher_->ended();
  }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;

 private:
  SessionWatcher* watcher_;
};

void finish_tools(std::vector<HandAtDevice>& hands, ContactWatch* watch, SessionResult& out) {
  StateHash hash;
  for (std::size_t k = 0; k < out.tools.size(); ++k) {
    ToolRun& tool = out.tools[k];
    for (const LocalFrame& f : tool.frames) {
      hash.add(f.pose.x);
      hash.add(f.force);
      hash.add(f.toi);
      hash.add(static_cast<int>(f.mode));
      hash.add(f.triangle);
    }
    tool.limited_forces = hands[k].limited_forces();
    tool.passivity = hands[k].energy();
    if (!watch) continue;
    tool.penetration = watch->take_penetration(k);
    tool.penetration.resize(tool.frames.size());
    tool.lost = watch->lost(k);
    tool.missed_impacts = tool.lost.free_ticks_inside + tool.lost.pass_throughs;
  }
  out.hash = hash.value();
}

}  // namespace

std::vector<Vec3> places_of(const ToolRun& run) {
  std::vector<Vec3> out{run.start.x};
  for (const LocalFrame& f : run.frames) out.push_back(f.pose.x);
  return out;
}

SessionOptions replay_of(const SessionResult& run) {
  SessionOptions out;
  out.replay = {run.refreshes, run.reducer_changes, run.setting_changes};
  for (const ToolRun& tool : run.tools) out.max_speeds.push_back(tool.max_speed);
  return out;
}

// In braces, in order: what is wrong with a setting is told before the mesh is filled.
Session::Session(const Scene& scene) : Session{scene, touch_options(scene), Body(body_options(scene))} {}

Session::Session(const Scene& scene, Mesh body)
    : Session{scene, touch_options(scene), Body(std::move(body), body_options(scene))} {}

Session::Session(const Scene& scene, std::unique_ptr<DeformableModel> model)
    : Session{scene, touch_options(scene), Body(std::move(model), body_options(scene))} {}

Session::Session(const Scene& scene, TouchOptions options, Body body)
    : scene_(scene), options_(std::move(options)), body_(std::move(body)), tools_(shapes_of(options_)) {
  scene_.local = options_.local;
  warnings_ = unused_settings(scene_);
  std::ranges::copy(body_.notes(), std::back_inserter(warnings_));
  friction_ = scene_friction(scene_.contact, body_.surface(), body_.model().mesh().x, warnings_);
  notes_ = warnings_;
  std::ranges::copy(body_.warnings() | std::views::drop(body_.notes().size()), std::back_inserter(warnings_));
  Mesh hanging = body_.model().mesh();
  hanging.x = body_.start().x;
  paths_ = scene_paths(scene_, tools_, hanging, warnings_);
  predictions_ = predict_failures(*this);
  for (const Prediction& known : predictions_) warnings_.push_back(known.message);
}

void Session::follow(std::vector<TimedPoint> path) {
  if (path.empty() || !(path.back().t > 0)) throw InputError("tool.path: takes no time");
  std::vector<Waypoint> waypoints;
  for (const TimedPoint& p : path) waypoints.push_back({p.t, p.x});
  scene_.tool.path = {.press_drag = {}, .waypoints = std::move(waypoints), .recording = {}, .hand = {}};
  scene_.duration = path.back().t;
  paths_[0] = {std::move(path), {}};
  scene_device(scene_, scene_.tool, paths_[0]);  // a wrong path is found now and not by run()
}

void Session::hold() {
  const ToolPath& path = paths_[0];
  const Vec3 start = path.poses.empty() ? path.points.front().x : path.poses.front().pose.x;
  SceneHand hand = scene_.tool.path.hand.value_or(SceneHand{});
  if (!scene_.tool.path.hand)
    hand.damping = 2 * std::sqrt(hand.stiffness * hand.mass);  // critical: nobody is there to damp it
  hand.target = {{0, start}, {1, start}};
  scene_.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = std::move(hand)};
  paths_[0] = {{{0, start}, {1, start}}, {}};
}

Session::~Session() = default;

/// Of both tools' paths, of a hand that of its target. As a ball: a longer tool asks for no other rates.
std::optional<BandPowers> Session::followed_motion() const {
  if (options_.local.reducer != "auto") return {};
  const double use =
      (1 + (models_come_late(options_) ? 1 : 0)) / options_.global.rate_hz + 1e-3 * options_.link.latency_ms;
  BandPowers out{};
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const FollowedMotion followed(surface(), start().x, tools_[k].radius, options_.contact.mu_static);
    const BandPowers its = path_powers(paths_[k].points, followed, options_.local.rate_hz, use);
    out.total += its.total;
    for (std::size_t b = 0; b < kBands; ++b) out.changing[b] += its.changing[b];
  }
  if (!(out.total > 0)) return {};
  return out;
}

/// The devices of the scene's tools, or what they did in the run that is replayed.
std::vector<std::unique_ptr<HapticDevice>> Session::devices(const SessionOptions& options) const {
  std::vector<std::unique_ptr<HapticDevice>> out;
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const SceneTool& tool = k == 0 ? scene_.tool : *scene_.second_tool;
    out.push_back(scene_device(scene_, tool, paths_[k], k == 0 ? options.target : nullptr));
    if (k < options.tool_paths.size())
      out[k] = played_again(options.tool_paths[k], tool, out[k]->info(), 1 / scene_.local.rate_hz);
  }
  return out;
}

SessionResult Session::run(const SessionOptions& options) {
  SessionResult result;
  result.warnings = warnings_;
  result.notes = notes_;
  const bool threaded = scene_.link.type == "thread" && options.replay.refreshes.empty();
  const double h = 1 / scene_.local.rate_hz;

  std::vector<std::unique_ptr<HapticDevice>> devices = this->devices(options);
  std::vector<Pose> start;
  TouchOptions touched = options_;
  touched.motion = followed_motion();
  touched.replay = options.replay;
  result.tools.resize(tools_.size());
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    ToolRun& tool = result.tools[k];
    tool.start = devices[k]->pose(0);
    start.push_back(tool.start);
    const bool is_given = k < options.max_speeds.size() && options.max_speeds[k] > 0;
    tool.max_speed = is_given ? options.max_speeds[k] : devices[k]->max_speed();
    touched.tools[k].max_speed = tool.max_speed;
  }
  Touch touch(body_, touched);
  std::optional<ContactWatch> watch;
  if (options.check_contacts) watch.emplace(body_.surface(), tools_, threaded);
  if (watch) touch.observe(&*watch);
  touch.slow().refresher().look_for_crossings = options.check_contacts && !threaded;
  touch.place(start);
  std::vector<HandAtDevice> hands;
  for (std::size_t k = 0; k < tools_.size(); ++k)
    hands.emplace_back(std::move(devices[k]), scene_.local.passivity_damping, h);
  int ticks = static_cast<int>(std::llround(scene_.duration * scene_.local.rate_hz));
  if (options.is_endless) ticks = std::numeric_limits<int>::max();
  const RunParts parts{options, ticks, touch, hands, watch ? &*watch : nullptr, result};
  {
    const Watched watched(options.watcher, touch);
    threaded ? run_threads(parts) : run_lockstep(parts);
  }
  if (options.is_endless) {
    ticks = touch.next_tick();
    scene_.duration = ticks * h;
    result.stopped = false;  // that is how it ends
  }

  if (watch) watch->finish(touch.fast().model());
  finish_tools(hands, watch ? &*watch : nullptr, result);
  result.last_dof = touch.fast().model().model.dof();
  result.last_patch_vertices = touch.fast().model().model.patch.num_vertices();
  Refresher& refresher = touch.slow().refresher();
  result.refreshes = std::move(touch.slow().events);
  for (RefreshEvent& event : result.refreshes)
    if (event.adopted_tick >= ticks) event.adopted_tick = -1;  // the run was over by then
  result.slow_cpu_ms = std::move(touch.slow().slow_cpu_ms);
  result.setting_changes = touch.slow().changes();
  result.deadline_misses =
      static_cast<int>(std::ranges::count_if(result.step_us, [&](double us) { return us > 1e6 * h; }));
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
  result.refresh_budget_ms = refresh_budget_ms(options_);
  result.certified_error = refresher.choice().certified_error();
  result.damping_coupling = refresher.coupling;
  result.exact_steps = refresher.exact_steps;
  result.linearization_error = std::move(refresher.linearization_error);
  if (threaded) warn_of_lag(scene_, result);
  for (std::size_t k = 0; k < result.tools.size(); ++k) {
    warn_of_speed(result.tools[k], h, k == 0 ? "tool.path: " : "second_tool.path: ", result.warnings);
    warn_of_activity(result.tools[k].passivity, result);
  }
  if (body_.self_contact()) result.self_contact = summarize(*body_.self_contact(), refresher);
  result.definite_tangents = refresher.definite_tangents;
  result.looked_ahead = refresher.looked_ahead;
  result.global_steps = refresher.statistics();
  result.inverted = refresher.inverted;
  if (result.inverted.most > 0)
    result.warnings.push_back(
        text(result.inverted.most, " of ", model().mesh().tetrahedra.size(),
             " tetrahedra turned inside out, first at t = ", result.inverted.from,
             result.inverted.last > 0 ? text(" s, and ", result.inverted.last, " are at the end") : " s, and came back",
             ": forces from then on are not to be trusted; press less deep, or refine the mesh"));
  return result;
}

}  // namespace kt
