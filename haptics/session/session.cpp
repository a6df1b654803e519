#include "haptics/session/session.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <ranges>

#include "core/body/state.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/safety/passivity.hpp"
#include "haptics/session/session_run.hpp"
#include "haptics/setup/path_excitation.hpp"
#include "haptics/setup/scene_safety.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "self_contact/crossings.hpp"

namespace kt {
namespace {

/// What is written down of a run as it goes, besides its ticks.
class RunRecorder final : public ModelObserver {
 public:
  RunRecorder(ContactWatch* watch, const SessionOptions& options, SessionResult& out)
      : watch_(watch), options_(options), out_(out) {}
  void adopted(const PreparedLocalModel& model) noexcept override {
    if (watch_) watch_->adopted(model);
  }
  bool look_back(const PreparedLocalModel& model, int most) override {
    return watch_ && watch_->look_back(model, most);
  }
  void refreshed(const RefreshRecord& record) override {
    if (options_.watcher) options_.watcher->refreshed(record);
    if (!options_.keeps_records) return;
    out_.refreshes.push_back(record.event);
    out_.refresh.add(record);
    std::ranges::copy(record.settings, std::back_inserter(out_.setting_changes));
    std::ranges::copy(record.reducers, std::back_inserter(out_.reducer_changes));
  }

 private:
  ContactWatch* watch_;
  const SessionOptions& options_;
  SessionResult& out_;
};

/// The one in use at the end.
/// @param is_remote  the choice was made on the body's computer, which tells its outcome alone
void tell_of_reducer(const Touch& touch, bool is_remote, SessionResult& result) {
  if (is_remote) {
    const TouchStatus status = touch.status();
    result.reducer = result.reducer_name = status.reducer;
    result.reducer_reason = "chosen on the body's computer";
    result.expected_force_error = status.expected_force_error;
    result.certified_error = status.certified_error;
    return;
  }
  const ReducerChoice& choice = TouchHalves::slow(touch).refresher().choice();
  result.reducer = choice.chosen().reducer;
  result.reducer_name = choice.chosen().name;
  result.reducer_reason = choice.reason();
  result.reducer_candidates = choice.candidates();
  result.expected_force_error = choice.expected_force_error();
  result.certified_error = choice.certified_error();
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

/// A body without self-contact passes through itself unseen.
SelfCrossing find_self_crossing(const Body& body, const Refresher& refresher) {
  SelfCrossing out{.pairs = 0};
  const std::vector<Triangle>& triangles = body.surface().triangles;
  std::optional<std::vector<Crossing>> before;
  for (const State* s : {&refresher.most_deformed(), &refresher.state()}) {
    if (s->x.size() != body.start().x.size() || s->t == body.start().t) continue;
    std::vector<Crossing> now = find_piercings(triangles, s->x);
    if (now.empty()) continue;
    if (!before) before = find_piercings(triangles, body.start().x);
    std::erase_if(now, [&](const Crossing& c) {
      return std::ranges::find(*before, c.triangles, &Crossing::triangles) != before->end();
    });
    if (static_cast<int>(now.size()) > out.pairs) out = {static_cast<int>(now.size()), s->t, now.front().at};
  }
  return out;
}

std::optional<PassivityRun> energy_of(const PassivityControl* control) {
  if (!control) return {};
  const PassivityControl& p = *control;
  return PassivityRun{p.least(), p.most(), p.most_debt(), p.given_by_hold(), p.damped_ticks()};
}

DeviceRun device_run(const GuardedDevice& device, const SceneTool& tool) {
  const SafetyChain& chain = device.chain();
  return {tool.path.device->name,     device.device().info(), chain.max_force(),
          device.device().origin(),   chain.counts(),         chain.reason(),
          chain.last_reason(),        chain.delay(),          chain.coupling(),
          energy_of(chain.turning()), device.device().notes()};
}

void finish_tools(const Scene& scene, std::vector<GuardedDevice>& devices, ContactWatch* watch, SessionResult& out) {
  StateHash hash;
  for (std::size_t k = 0; k < out.tools.size(); ++k) {
    ToolRun& tool = out.tools[k];
    const bool is_live = devices[k].device().info().is_live;
    for (std::size_t i = 0; i < tool.frames.size(); ++i) {
      const LocalFrame& f = tool.frames[i];
      hash.add(f.pose.x);
      hash.add(is_live ? tool.model_force[i] : f.force);  // what a gate let through went by the clock: no replay has it
      hash.add(f.toi);
      hash.add(static_cast<int>(f.mode));
      hash.add(f.triangle);
    }
    tool.limited_forces = devices[k].chain().counts().limited;
    tool.passivity = energy_of(devices[k].chain().passivity());
    if (is_live) tool.device = device_run(devices[k], k == 0 ? scene.tool : *scene.second_tool);
    if (!watch) continue;
    tool.penetration = watch->take_penetration(k);
    tool.penetration.resize(tool.frames.size(), 0.0);
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

Session::Session(const Scene& scene, SceneFiles files)
    : BuiltScene(scene, std::move(files)), predictions_(predict_failures(*this)) {}

Session::Session(const Scene& scene, Mesh body)
    : BuiltScene(scene, std::move(body)), predictions_(predict_failures(*this)) {}

Session::Session(const Scene& scene, std::unique_ptr<DeformableModel> model)
    : BuiltScene(scene, std::move(model)), predictions_(predict_failures(*this)) {}

/// Of both tools' paths, of a hand that of its target. As a ball: a longer tool asks for no other rates.
std::optional<BandPowers> Session::followed_motion() const {
  const double use =
      (1 + (models_come_late(options()) ? 1 : 0)) / options().global.rate_hz + 1e-3 * options().link.latency_ms;
  BandPowers out{};
  for (std::size_t k = 0; k < tools().size(); ++k) {
    const FollowedMotion followed(surface(), start().x, tools()[k].radius, options().contact.mu_static);
    const BandPowers its = path_powers(paths()[k].points, followed, options().local.rate_hz, use);
    out.total += its.total;
    for (std::size_t b = 0; b < kBands; ++b) out.changing[b] += its.changing[b];
  }
  if (!(out.total > 0)) return {};
  return out;
}

/// As the scene says, or how deep its path goes into the body at rest, as a ball's. Of two tools the least: one that
/// lifts the other's side goes where the body was, and is not pressed in by it. The other computer of a network does
/// not know it.
double Session::press_depth() const {
  if (scene().link.type == "network") return 0;
  if (const auto& press = scene().tool.path.press_drag; press && tools().size() == 1) return press->depth;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < tools().size(); ++k)
    least = std::min(least, path_depth(paths()[k].points, FollowedMotion(surface(), start().x, tools()[k].radius, 0)));
  return least;
}

/// The devices of the scene's tools, or what they did in the run that is replayed.
std::vector<std::unique_ptr<HapticDevice>> Session::devices(const SessionOptions& options) const {
  std::vector<std::unique_ptr<HapticDevice>> out;
  for (std::size_t k = 0; k < tools().size(); ++k) {
    const SceneTool& tool = k == 0 ? scene().tool : *scene().second_tool;
    const bool is_replayed = k < options.tool_paths.size();
    DeviceInfo info;
    if (!is_replayed || !tool.path.device) {
      out.push_back(scene_device(scene(), tool, paths()[k], k == 0 ? options.target : nullptr, options.pushed));
      info = out[k]->info();
    } else {
      out.emplace_back();
    }
    if (is_replayed) out[k] = played_again(options.tool_paths[k], tool, info, 1 / scene().local.rate_hz);
  }
  return out;
}

SessionResult Session::run(const SessionOptions& options) {
  SessionResult result;
  result.findings = findings();
  const bool is_replay = !options.replay.refreshes.empty();
  if (scene().link.type == "network" && !options.link && !is_replay)
    throw InputError(
        "link.type network: the body is on another computer (kilotouch serve, kilotouch touch); kilotouch run has it "
        "beside");
  const bool threaded = scene().link.type != "lockstep" && !is_replay;
  const double h = 1 / scene().local.rate_hz;

  std::vector<std::unique_ptr<HapticDevice>> devices = this->devices(options);
  std::vector<Pose> start;
  TouchOptions touched = this->options();
  if (const auto motion = followed_motion()) touched.motion = std::make_shared<const BandPowers>(*motion);
  touched.press_depth = press_depth();
  touched.replay = options.replay;
  result.tools.resize(tools().size());
  for (std::size_t k = 0; k < tools().size(); ++k) {
    ToolRun& tool = result.tools[k];
    tool.start = devices[k]->pose(0);
    start.push_back(tool.start);
    const bool is_given = k < options.max_speeds.size() && options.max_speeds[k] > 0;
    tool.max_speed = is_given ? options.max_speeds[k] : devices[k]->max_speed();
    touched.tools[k].max_speed = tool.max_speed;
  }
  std::optional<ContactWatch> watch;
  if (options.check_contacts) watch.emplace(body().surface(), tools(), threaded, h);
  RunRecorder recorder(watch ? &*watch : nullptr, options, result);
  Touch touch(body(), touched);
  TouchHalves::observe(touch, &recorder);
  touch.check_contacts(false);  // it has its own watch
  TouchHalves::slow(touch).refresher().look_for_crossings = options.check_contacts && !threaded;
  touch.place(start);
  std::vector<GuardedDevice> guarded;
  for (std::size_t k = 0; k < tools().size(); ++k)
    guarded.emplace_back(std::move(devices[k]), safety_options(scene(), k == 0 ? scene().tool : *scene().second_tool));
  for (std::size_t k = 0; k < tools().size(); ++k) guarded[k].begin_at(start[k].x);  // it has moved on since then
  int ticks = static_cast<int>(std::llround(scene().duration * scene().local.rate_hz));
  const bool is_endless = options.is_endless || scene().is_endless;
  if (is_endless) ticks = std::numeric_limits<int>::max();
  const RunParts parts{options, ticks, touch, guarded, watch ? &*watch : nullptr, result};
  {
    const Watched watched(options.watcher, touch);
    threaded ? run_threads(parts) : run_lockstep(parts);
    touch.stop();
  }
  if (is_endless || result.stopped) {  // a replay ends there
    ticks = result.records_full.empty() ? touch.next_tick() : static_cast<int>(result.step_us.size());
    if (ticks > 0) last(ticks * h);
    if (is_endless) result.stopped = !result.records_full.empty();  // else that is how it ends
  }

  if (watch) watch->finish(TouchHalves::fast(touch).model());
  finish_tools(scene(), guarded, watch ? &*watch : nullptr, result);
  result.last_dof = TouchHalves::fast(touch).model().model.dof();
  result.last_patch_vertices = TouchHalves::fast(touch).model().model.patch.num_vertices();
  const Refresher& refresher = TouchHalves::slow(touch).refresher();
  for (RefreshEvent& event : result.refreshes)
    if (event.adopted_tick >= ticks) event.adopted_tick = -1;  // the run was over by then
  result.deadline_misses =
      static_cast<int>(std::ranges::count_if(result.step_us, [&](double us) { return us > 1e6 * h; }));
  const bool is_remote = options.link != nullptr && threaded;
  tell_of_reducer(touch, is_remote, result);
  result.refresh_budget_ms = refresh_budget_ms(this->options());
  if (const SelfContact* contact = body().self_contact()) {
    result.self_contact = result.refresh.self_contact();
    result.self_contact->reach = contact->options.reach;
    result.self_contact->stiffness = contact->options.stiffness;
  } else if (options.check_contacts && !is_remote) {
    result.self_crossing = find_self_crossing(body(), refresher);
  }
  result.refresh.energy = touch.status().energy;
  result.global_steps = refresher.statistics();
  return result;
}

}  // namespace kt
