// Both rates in one thread: deterministic. Latency and loss of the link are simulated in ticks, from the scene's seed;
// a replay brings its own schedule.
#include <cmath>
#include <deque>
#include <random>

#include "haptics/session_run.hpp"

namespace kt {
namespace {

std::vector<RefreshEvent> make_schedule(const Scene& scene, int num_ticks, int ticks_per_refresh) {
  const int latency = static_cast<int>(std::llround(scene.link.latency_ms * 1e-3 * scene.local.rate_hz));
  std::mt19937_64 random(scene.seed);
  std::vector<RefreshEvent> out;
  for (int tick = 0; tick < num_ticks; tick += ticks_per_refresh) {
    // 53 random bits: the same on every standard library, which uniform_real_distribution is not.
    const bool lost = static_cast<double>(random() >> 11) * 0x1p-53 < scene.link.loss;
    const bool first = tick == 0;  // the set-up model is there before the first tick
    out.push_back({tick, first ? 0 : lost ? -1 : tick + latency});
  }
  return out;
}

}  // namespace

void run_lockstep(const RunParts& run) {
  HapticLoop& haptic = run.haptic;
  std::vector<RefreshEvent> schedule = run.options.refreshes;
  if (schedule.empty()) schedule = make_schedule(run.scene, haptic.num_ticks(), run.ticks_per_refresh);

  std::deque<std::pair<int, std::unique_ptr<PreparedLocalModel>>> on_the_way;
  std::vector<LocalReport> reports;
  std::size_t next_refresh = 0, next_snapshot = 0;
  for (int tick = 0; tick < haptic.num_ticks(); ++tick) {
    if (next_refresh < schedule.size() && schedule[next_refresh].linearized_tick == tick) {
      const RefreshEvent event = schedule[next_refresh++];
      auto model = run.refresher.refresh(tick / run.scene.local.rate_hz, haptic.tool_position(), reports);
      reports.clear();
      run.result.refreshes.push_back(event);
      if (event.adopted_tick >= 0) on_the_way.emplace_back(event.adopted_tick, std::move(model));
    }
    while (!on_the_way.empty() && on_the_way.front().first <= tick) {
      haptic.adopt(std::move(on_the_way.front().second));
      on_the_way.pop_front();
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
