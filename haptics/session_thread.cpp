// Two threads against the wall clock: the haptic loop at its rate, the refresher beside it as fast as it can, up to the
// global rate. Every exchange is recorded by tick, so that a lockstep replay repeats the run bit for bit.
#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <cmath>
#include <thread>

#include "haptics/link/mailbox.hpp"
#include "haptics/link/ring.hpp"
#include "haptics/session_run.hpp"

namespace kt {
namespace {

/// A local model on its way, with the tick it was made for.
struct Parcel {
  int linearized_tick = 0;
  std::unique_ptr<PreparedLocalModel> model;
};

timespec plus(timespec t, double seconds) {
  const long long ns = t.tv_nsec + std::llround(seconds * 1e9);
  t.tv_sec += ns / 1000000000;
  t.tv_nsec = ns % 1000000000;
  return t;
}

double difference_us(const timespec& a, const timespec& b) {
  return 1e6 * static_cast<double>(a.tv_sec - b.tv_sec) + 1e-3 * static_cast<double>(a.tv_nsec - b.tv_nsec);
}

bool ask_for_real_time() {
  sched_param param{};
  param.sched_priority = 50;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &param) == 0;
}

class ThreadedRun {
 public:
  explicit ThreadedRun(const RunParts& run) : run_(run), down_(), up_(4096) {}

  void go() {
    Parcel first{0, run_.refresher.refresh(0, run_.haptic.tool_position(), {})};
    run_.result.refreshes.push_back({0, 0});
    run_.haptic.adopt(std::move(first.model));
    run_.result.lateness_us.resize(run_.haptic.num_ticks());
    adopted_.reserve(static_cast<std::size_t>(run_.haptic.num_ticks()));
    std::thread haptic([this] { haptic_thread(); });
    try {
      refresh_loop();
    } catch (...) {
      stop_ = true;
      haptic.join();
      throw;
    }
    haptic.join();
    run_.result.lateness_us.resize(run_.haptic.next_tick());
    record_refreshes();
    // Snapshots would stall the haptic loop: the end is what remains.
    run_.result.snapshots.push_back(run_.haptic.snapshot(run_.refresher.state().x));
  }

 private:
  void haptic_thread() {
    run_.result.real_time_scheduling = ask_for_real_time();
    timespec start{};
    clock_gettime(CLOCK_MONOTONIC, &start);
    const double h = 1 / run_.scene.local.rate_hz;
    for (int tick = 0; tick < run_.haptic.num_ticks() && !stop_; ++tick) {
      const timespec due = plus(start, tick * h);
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) != 0) {
      }
      timespec now{};
      clock_gettime(CLOCK_MONOTONIC, &now);
      run_.result.lateness_us[tick] = difference_us(now, due);
      // A model is taken only when the used one can be handed back: freeing is not for this thread.
      if (used_.is_empty())
        if (auto parcel = down_.take()) {
          adopted_.push_back({parcel->linearized_tick, tick});
          parcel->model = run_.haptic.adopt(std::move(parcel->model));
          used_.put(std::move(parcel));
        }
      if (!up_.push(run_.haptic.tick())) ++lost_reports_;
    }
    finished_ = true;
  }

  /// The refresher always works for the latest whole refresh interval that the haptic loop has completed.
  void refresh_loop() {
    std::vector<LocalReport> pending;
    LocalReport item;
    int last = 0;
    while (!finished_) {
      while (up_.pop(item)) pending.push_back(item);
      used_.take();
      const int done = pending.empty() ? last : pending.back().tick + 1;
      const int tick = done / run_.ticks_per_refresh * run_.ticks_per_refresh;
      if (tick <= last) {
        std::this_thread::sleep_for(std::chrono::microseconds(300));
        continue;
      }
      std::size_t count = 0;
      while (count < pending.size() && pending[count].tick < tick) ++count;
      const std::span<const LocalReport> reports(pending.data(), count);
      auto parcel = std::make_unique<Parcel>();
      parcel->linearized_tick = tick;
      parcel->model = run_.refresher.refresh(tick / run_.scene.local.rate_hz, reports.back().tool, reports);
      pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(count));
      down_.put(std::move(parcel));
      linearized_.push_back(tick);
      last = tick;
      if (run_.options.progress) run_.options.progress(static_cast<double>(tick) / run_.haptic.num_ticks());
      if (run_.options.stop && run_.options.stop->load()) {
        run_.result.stopped = true;
        stop_ = true;
      }
    }
    if (lost_reports_ > 0)
      run_.result.warnings.push_back(
          text("link: ", lost_reports_, " reports were lost, the refresher fell too far behind"));
  }

  /// Every linearization moved the global side on, also those that came too late to be adopted.
  void record_refreshes() {
    std::size_t next = 0;
    for (int tick : linearized_) {
      const bool adopted = next < adopted_.size() && adopted_[next].linearized_tick == tick;
      run_.result.refreshes.push_back({tick, adopted ? adopted_[next++].adopted_tick : -1});
    }
  }

  const RunParts& run_;
  Mailbox<Parcel> down_, used_;
  Ring<LocalReport> up_;
  std::vector<RefreshEvent> adopted_;
  std::vector<int> linearized_;
  std::atomic<bool> finished_{false}, stop_{false};
  int lost_reports_ = 0;
};

}  // namespace

void run_threads(const RunParts& run) { ThreadedRun(run).go(); }

}  // namespace kt
