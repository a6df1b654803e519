// Both rates in one thread: deterministic. Latency and loss of the link are simulated in ticks, from the scene's seed;
// a replay brings its own schedule.
#include <cmath>
#include <deque>
#include <random>

#include "haptics/refresh_cost.hpp"
#include "haptics/session_run.hpp"

namespace kt {
namespace {

/// Ticks that a new local model is stepped beside the old one before it takes over: the parts of the body that it
/// follows and the old one did not start from rest. Without them its first forces can be a quarter off.
constexpr int kRunIn = 4;

/// A local model on its way.
struct Parcel {
  int due_tick = 0, at_tick = 0;  ///< when it arrives; where its state stands
  std::unique_ptr<PreparedLocalModel> model;
};

/// When the body is refreshed, and which local models arrive: from the scene, or as it was in the run that is replayed.
class Schedule {
 public:
  Schedule(const RunParts& run)
      : run_(run),
        latency_(static_cast<int>(std::llround(run.scene.link.latency_ms * 1e-3 * run.scene.local.rate_hz))),
        random_(run.scene.seed) {}

  bool is_due(int tick, bool wanted_now) const {
    const std::vector<RefreshEvent>& replayed = run_.options.refreshes;
    if (!replayed.empty()) return next_ < replayed.size() && replayed[next_].linearized_tick == tick;
    const int least =
        std::max(1, run_.ticks_per_refresh / 8);  // a slow side that is asked every tick does nothing else
    return tick >= busy_until_ && (tick >= due_ || (wanted_now && tick >= last_ + least));
  }

  RefreshEvent take(int tick) {
    last_ = tick;
    if (!run_.options.refreshes.empty()) return run_.options.refreshes[next_++];
    // 53 random bits: the same on every standard library, which uniform_real_distribution is not.
    const bool lost = static_cast<double>(random_() >> 11) * 0x1p-53 < run_.scene.link.loss;
    const bool first = tick == 0;  // the set-up model is there before the first tick
    return {tick, first ? 0 : lost ? -1 : tick + latency_};
  }

  void set_next(int tick) { due_ = std::max(tick, busy_until_); }

  /// The slow side takes that many ticks for the refresh that begins at this one: it does nothing else meanwhile, and
  /// its local model is as late.
  void charge(int tick, int ticks, RefreshEvent& event) {
    busy_until_ = tick + ticks;
    if (event.adopted_tick >= 0) event.adopted_tick += ticks;
    // The run is over by then.
    if (ticks > 0 && event.adopted_tick >= run_.haptic.num_ticks()) event.adopted_tick = -1;
  }

  /// The next local model, when it comes as planned, starts from the motion at this tick.
  bool is_start(int tick) const {
    const std::vector<RefreshEvent>& replayed = run_.options.refreshes;
    if (!replayed.empty()) return next_ < replayed.size() && replayed[next_].started_tick == tick;
    if (models_come_late(run_.scene)) return false;  // later than it takes to run in
    return tick == std::max(last_ + 1, due_ - std::max(0, kRunIn - latency_));
  }

 private:
  const RunParts& run_;
  int latency_, due_ = 0, last_ = 0, busy_until_ = 0;
  std::size_t next_ = 0;
  std::mt19937_64 random_;
};

}  // namespace

void run_lockstep(const RunParts& run) {
  HapticLoop& haptic = run.haptic;
  Schedule schedule(run);
  std::deque<Parcel> on_the_way;
  std::vector<LocalReport> reports;
  LocalMotion motion = make_local_motion(static_cast<int>(run.refresher.state().x.size()) / 3);
  bool has_start = false;
  std::size_t next_snapshot = 0;
  for (int tick = 0; tick < haptic.num_ticks(); ++tick) {
    // At the edge of the patch, a new one is asked for once; the answer takes its time.
    const bool wanted =
        !reports.empty() && reports.back().left_patch && on_the_way.empty() && run.scene.global.early_refresh;
    if (schedule.is_due(tick, wanted)) {
      RefreshEvent event = schedule.take(tick);
      const bool goes_on = tick > 0 && catches_up(run.scene);
      if (goes_on && !has_start) haptic.record_motion(motion);
      if (goes_on) event.started_tick = motion.tick;
      has_start = false;
      const double predicted_ms = tick > 0 ? run.refresher.choice().predicted_refresh_ms() : 0;
      const double start = process_time_ms();
      auto model = run.refresher.refresh(tick / run.scene.local.rate_hz, haptic.tool_positions(), reports,
                                         goes_on ? &motion : nullptr);
      const double took_ms = process_time_ms() - start;
      run.result.slow_cpu_ms.push_back(took_ms);
      if (const bool is_replayed = !run.options.refreshes.empty(); !is_replayed && tick > 0) {
        schedule.charge(tick, charged_ticks(run.scene, took_ms, predicted_ms), event);
        if (models_come_late(run.scene)) run.refresher.charge(charged_ms(run.scene, took_ms, predicted_ms));
      }
      reports.clear();
      schedule.set_next(tick + run.refresher.next_interval(run.ticks_per_refresh));
      run.result.refreshes.push_back(event);
      if (event.adopted_tick >= 0) on_the_way.push_back({event.adopted_tick, event.started_tick, std::move(model)});
    }
    while (!on_the_way.empty() && on_the_way.front().due_tick <= tick) {
      auto& [due_tick, at_tick, model] = on_the_way.front();
      if (catches_up(run.scene)) haptic.catch_up(model, at_tick, tick);
      haptic.adopt(std::move(model));
      on_the_way.pop_front();
    }
    if (tick > 0 && catches_up(run.scene) && schedule.is_start(tick)) {
      haptic.record_motion(motion);
      has_start = true;
    }
    reports.push_back(haptic.tick());

    const double t = (tick + 1) / run.scene.local.rate_hz;
    for (; next_snapshot < run.options.snapshot_times.size() && run.options.snapshot_times[next_snapshot] <= t;
         ++next_snapshot)
      run.result.snapshots.push_back(haptic.snapshot(run.refresher.state().x));
    if (run.options.progress) run.options.progress((tick + 1.0) / haptic.num_ticks());
    if (run.options.stop && run.options.stop->load()) {
      run.result.stopped = true;
      break;
    }
  }
}

}  // namespace kt
