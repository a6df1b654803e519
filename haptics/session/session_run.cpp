#include "haptics/session/session_run.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/base/cpu_time.hpp"
#include "core/base/error.hpp"
#include "core/base/ticks.hpp"
#include "haptics/driver/device_slots.hpp"
#include "haptics/link/ring.hpp"
#include "haptics/machine/real_time_thread.hpp"
#include "haptics/session/body_film.hpp"
#include "haptics/touch/touch_halves.hpp"

namespace kt {
namespace {

/// What a tick leaves in the records.
struct TickRow {
  std::array<LocalFrame, kMaxTools> frames;
  std::array<Vec3, kMaxTools> model_force;
  std::array<double, kMaxTools> pose_age;  // [s]
  double step_us = 0, lateness_us = 0;
  long long allocations = 0;
};

timespec plus(timespec t, double seconds) {
  const long long ns = t.tv_nsec + std::llround(seconds * 1e9);
  t.tv_sec += ns / 1000000000;
  t.tv_nsec = ns % 1000000000;
  if (t.tv_nsec < 0) {
    t.tv_nsec += 1000000000;
    --t.tv_sec;
  }
  return t;
}

double difference_us(const timespec& a, const timespec& b) {
  return 1e6 * static_cast<double>(a.tv_sec - b.tv_sec) + 1e-3 * static_cast<double>(a.tv_nsec - b.tv_nsec);
}

/// A tick a period of the wall clock.
class WallClock {
 public:
  explicit WallClock(double h) : h_(h) { clock_gettime(CLOCK_MONOTONIC, &start_); }
  /// Time goes on from here with this tick.
  void restart(int tick) noexcept {
    clock_gettime(CLOCK_MONOTONIC, &start_);
    start_ = plus(start_, -tick * h_);
  }
  /// Sleeps until the tick is due. Returns how late that is over [us].
  double wait_for(int tick) noexcept {
    const timespec due = plus(start_, tick * h_);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) != 0) {
    }
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return difference_us(now, due);
  }

 private:
  timespec start_{};
  double h_;
};

/// The devices' tick: poses from them, forces to them.
class DeviceTick {
 public:
  explicit DeviceTick(const RunParts& run)
      : run_(run),
        is_live_(std::ranges::any_of(run.devices, [](const GuardedDevice& d) { return d.device().info().is_live; })) {}

  /// @param refresh  the refresh that is due first, whose time is not the tick's
  void step(TickRow& row, bool refresh) noexcept {
    const double h = run_.touch.h(), t_end = (run_.touch.next_tick() + 1) * h;
    const std::size_t count = run_.devices.size();
    const double dt = since_last(h);
    std::array<Pose, kMaxTools> poses;
    for (std::size_t k = 0; k < count; ++k) poses[k] = run_.devices[k].pose(t_end, dt);
    if (refresh) TouchHalves::refresh_if_due(run_.touch);
    const auto& counts = run_.options.count_allocations;
    const long long before = counts ? counts() : 0;
    const double start = thread_time_us();
    const std::span<const LocalFrame> frames = run_.touch.tick(std::span(poses).first(count));
    row.step_us = thread_time_us() - start;
    row.allocations = counts ? counts() - before : 0;
    allocations_ += row.allocations;
    if (run_.watch) run_.watch->ticked(TouchHalves::fast(run_.touch), frames);
    // What is recorded, counted as work and judged is what the hand is given.
    for (std::size_t k = 0; k < count; ++k) {
      row.frames[k] = frames[k];
      row.model_force[k] = run_.devices[k].give(row.frames[k], h, dt);
      row.pose_age[k] = run_.devices[k].state().age;
    }
  }
  /// A device that somebody holds has not been there for so long that it will not come back.
  bool has_lost_a_device() const noexcept {
    constexpr double kPatience = 10;  // [s]
    return std::ranges::any_of(run_.devices, [](const GuardedDevice& d) { return d.gone_for() > kPatience; });
  }
  /// A run is over: what somebody holds is put down, not let go.
  void put_down(const TickRow& last, WallClock& clock, int tick) noexcept {
    if (!is_live_) return;
    const double h = run_.touch.h();
    for (int i = 0; i * h < SafetyChain::kZeroWithin; ++i) {
      clock.wait_for(tick + i);
      for (std::size_t k = 0; k < run_.devices.size(); ++k) run_.devices[k].put_down(last.frames[k], h);
    }
  }
  long long allocations() const { return run_.options.count_allocations ? allocations_ : -1; }

 private:
  /// [s] since the tick before: of devices that somebody holds by the clock.
  double since_last(double h) noexcept {
    if (!is_live_) return h;
    const std::int64_t before = std::exchange(began_ns_, monotonic_ns());
    return before == 0 ? h : std::max(1e-9, 1e-9 * static_cast<double>(began_ns_ - before));
  }

  const RunParts& run_;
  bool is_live_;
  std::int64_t began_ns_ = 0;
  long long allocations_ = 0;
};

/// To who watches, and to the records, which a full disk ends.
class Recorder {
 public:
  explicit Recorder(const RunParts& run) : run_(run) {}

  /// @param is_late  against the wall clock: how late a tick was is recorded, too
  /// @return there was room for it
  bool add(const TickRow& row, bool is_late) {
    SessionResult& out = run_.result;
    if (SessionWatcher* watcher = run_.options.watcher)
      watcher->ticked(std::span(row.frames).first(out.tools.size()), row.step_us, row.allocations);
    if (!run_.options.keeps_records || !out.records_full.empty()) return out.records_full.empty();
    try {
      for (std::size_t k = 0; k < out.tools.size(); ++k) {
        out.tools[k].frames.push_back(row.frames[k]);
        out.tools[k].model_force.push_back(row.model_force[k]);
        if (run_.devices[k].device().info().is_live) out.tools[k].pose_age.push_back(row.pose_age[k]);
      }
      if (is_late) out.lateness_us.push_back(row.lateness_us);
      out.step_us.push_back(row.step_us);
    } catch (const RunError& e) {
      end(e.what());
      return false;
    }
    return true;
  }

 private:
  /// All lists end with the last whole tick.
  void end(const std::string& why) {
    SessionResult& out = run_.result;
    out.records_full = why;
    out.stopped = true;
    out.findings.push_back({why});
    const std::size_t ticks = out.step_us.size();
    for (ToolRun& tool : out.tools) {
      tool.frames.truncate(ticks);
      tool.model_force.truncate(ticks);
      tool.pose_age.truncate(ticks);
    }
    out.lateness_us.truncate(ticks);
  }

  const RunParts& run_;
};

/// Pictures of the body between ticks, while nobody else has it.
class Pictures {
 public:
  explicit Pictures(const RunParts& run) : run_(run) {}

  Snapshot take() {
    Touch& touch = run_.touch;
    Snapshot out{touch.next_tick() * touch.h(), {}, {}};
    for (const ToolRun& tool : run_.result.tools) out.tools.push_back(tool.frames.back().pose.x);
    TouchHalves::copy_positions_now(touch, out.x);
    return out;
  }

  void film() {
    if (!run_.options.film) return;
    const LocalFrame& frame = run_.result.tools[0].frames.back();
    const bool is_refreshed = frame.model_frame != model_frame_;
    model_frame_ = frame.model_frame;
    if (run_.options.film->is_due(frame.t, is_refreshed)) run_.options.film->add(frame.t, take().x);
  }

 private:
  const RunParts& run_;
  int model_frame_ = -1;
};

}  // namespace

void run_lockstep(const RunParts& run) {
  DeviceTick devices(run);
  Pictures pictures(run);
  Recorder recorder(run);
  TickRow row;
  std::size_t next_snapshot = 0;
  for (int tick = 0; tick < run.ticks; ++tick) {
    devices.step(row, true);
    if (run.touch.error()) std::rethrow_exception(run.touch.error());
    if (!recorder.add(row, false)) break;
    const double t = (tick + 1) * run.touch.h();
    for (; next_snapshot < run.options.snapshot_times.size() && run.options.snapshot_times[next_snapshot] <= t;
         ++next_snapshot)
      run.result.snapshots.push_back(pictures.take());
    pictures.film();
    if (run.options.progress) run.options.progress((tick + 1.0) / run.ticks);
    if (run.options.stop && run.options.stop->load()) {
      run.result.stopped = true;
      break;
    }
  }
  run.result.allocations = devices.allocations();
}

void run_threads(const RunParts& run) {
  if (run.options.link)
    TouchHalves::start(run.touch, run.options.link);
  else
    run.touch.start();
  DeviceTick devices(run);
  constexpr double kUnread = 2;  // [s] that this thread may be away
  Ring<TickRow> rows(static_cast<std::size_t>(ticks_in(kUnread, 1 / run.touch.h(), 8192, 1 << 16)));
  std::atomic<bool> stop{false}, finished{false};
  std::atomic<int> unrecorded{0};
  const std::atomic<bool>* const pause = run.options.pause;
  std::thread haptic([&] {
    RealTimeThread on_time;
    WallClock clock(run.touch.h());
    TickRow row;
    on_time.start();
    for (int tick = 0; tick < run.ticks && !stop && !run.touch.error(); ++tick) {
      if (devices.has_lost_a_device()) {
        run.result.device_lost = true;
        break;
      }
      if (pause && pause->load()) {
        while (pause->load() && !stop) std::this_thread::sleep_for(std::chrono::milliseconds(2));
        clock.restart(tick);
      }
      row.lateness_us = clock.wait_for(tick);
      devices.step(row, false);
      if (!rows.push(row)) ++unrecorded;
    }
    on_time.stop();
    devices.put_down(row, clock, run.touch.next_tick());
    run.result.real_time = on_time.grant();
    finished = true;
  });
  Recorder recorder(run);
  const auto take_rows = [&] {
    TickRow row;
    while (rows.pop(row))
      if (!recorder.add(row, true)) stop = true;
  };
  VectorX x;
  while (!finished) {
    take_rows();
    if (BodyFilm* film = run.options.film; film && !run.result.tools[0].frames.empty())
      if (const double t = run.result.tools[0].frames.back().t; film->is_due(t, false)) {
        run.touch.copy_positions(x);
        film->add(t, x);
      }
    const auto done = static_cast<double>(run.result.step_us.size());
    if (run.options.progress && done > 0) run.options.progress(done / run.ticks);
    if (run.options.stop && run.options.stop->load()) stop = run.result.stopped = true;
    std::this_thread::sleep_for(run.options.watcher ? std::chrono::milliseconds(4) : std::chrono::milliseconds(20));
  }
  haptic.join();
  take_rows();
  run.touch.stop();
  run.result.allocations = devices.allocations();
  if (const int lost = TouchHalves::lost_reports(run.touch); lost > 0)
    run.result.findings.push_back({text("link: ", lost, " reports were lost, the refresher fell too far behind")});
  if (unrecorded > 0)
    run.result.findings.push_back(
        {text("records: ", unrecorded.load(), " ticks were not recorded, the machine is too busy")});
  // Snapshots would stall the haptic loop: the end is what remains.
  if (!run.result.step_us.empty()) run.result.snapshots.push_back(Pictures(run).take());
}

}  // namespace kt
