// Two threads against the wall clock: the haptic loop at its rate, the refresher beside it as fast as it can, up to the
// global rate. Every exchange is recorded by tick, so that a lockstep replay repeats the run bit for bit.
#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <thread>

#include "haptics/link/mailbox.hpp"
#include "haptics/link/ring.hpp"
#include "haptics/session_run.hpp"

namespace kt {
namespace {

/// A local model on its way, with the tick it was made for and the tick where its state stands.
struct Parcel {
  int linearized_tick = 0, at_tick = 0;
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

constexpr int kAtOnce = 0, kBetween = 16;  // past ticks that are checked: before a refresh; while none is due
constexpr std::size_t kMostWaiting = 8;    // local models whose ticks are not checked yet
constexpr int kSoon = 2;  // ticks until the next refresh is due: the refresher asks for the motion
constexpr int kMost = 4;  // ticks that are caught up with in one: a tick is some 20 us, there is room for them

class ThreadedRun {
 public:
  explicit ThreadedRun(const RunParts& run)
      : run_(run),
        up_(4096),
        catches_up_(catches_up(run.scene)),
        catch_up_(run.tools, 1 / run.scene.local.rate_hz, scene_solver(run.scene, run.friction)),
        interval_(run.ticks_per_refresh) {
    turns_.push_back(scene_turn(run.scene.tool));
    if (run.scene.second_tool) turns_.push_back(scene_turn(*run.scene.second_tool));
  }

  void go() {
    const double start = process_time_ms();
    Parcel first{0, 0, run_.refresher.refresh(0, run_.haptic.tool_positions(), {})};
    run_.result.slow_cpu_ms.push_back(process_time_ms() - start);
    run_.result.refreshes.push_back({0, 0});
    run_.haptic.adopt(std::move(first.model));
    run_.result.lateness_us.resize(run_.haptic.num_ticks());
    adopted_.reserve(static_cast<std::size_t>(run_.haptic.num_ticks()));
    std::thread haptic([this] { haptic_thread(); });
    haptic_handle_ = haptic.native_handle();  // valid until it is joined
    try {
      refresh_loop();
    } catch (...) {
      stop_ = true;
      haptic.join();
      throw;
    }
    haptic.join();
    look_at_the_rest();
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
      if (!arrived_ && used_.is_empty()) arrived_ = down_.take();
      if (arrived_ && (!catches_up_ || run_.haptic.catch_up(arrived_->model, arrived_->at_tick, kMost))) {
        adopted_.push_back({arrived_->linearized_tick, tick});
        arrived_->model = run_.haptic.adopt(std::move(arrived_->model));
        used_.put(std::move(arrived_));
      }
      if (!up_.push(run_.haptic.tick())) ++lost_reports_;
      send_motion();
    }
    finished_ = true;
  }

  /// The refresher goes on from here, when it has asked for that; what it has not read is written over.
  void send_motion() {
    if (!next_motion_) next_motion_ = free_motion_.take();
    if (!next_motion_) return;
    run_.haptic.record_motion(*next_motion_);
    next_motion_ = motion_.put(std::move(next_motion_));
  }

  /// The refresher always works for the latest moment that the haptic loop has sent its motion of.
  void refresh_loop() {
    std::vector<LocalReport> pending;
    int last = 0;
    for (int i = 0; i < 3; ++i) spare_motions_.push_back(std::make_unique<LocalMotion>(make_local_motion(num_nodes())));
    std::unique_ptr<LocalMotion> motion;
    while (!finished_) {
      const bool is_due = !pending.empty() && (pending.back().tick + kSoon >= last + interval_ ||
                                               (run_.scene.global.early_refresh && pending.back().left_patch));
      if (is_due && !spare_motions_.empty() && free_motion_.is_empty()) {
        free_motion_.put(std::move(spare_motions_.back()));
        spare_motions_.pop_back();
      }
      if (auto newer = motion_.take()) {
        if (motion) spare_motions_.push_back(std::move(motion));
        motion = std::move(newer);
      }
      receive(pending);
      look_at_past(kAtOnce);
      const int tick = motion ? motion->tick : last;
      const bool cannot_wait =
          run_.scene.global.early_refresh && std::ranges::any_of(pending, [&](const LocalReport& report) {
            return report.tick < tick && report.left_patch;
          });
      if (tick < last + interval_ && !cannot_wait) {
        if (!look_at_past(kBetween)) std::this_thread::sleep_for(std::chrono::microseconds(300));
        continue;
      }
      std::size_t count = 0;
      while (count < pending.size() && pending[count].tick < tick) ++count;
      const std::span<const LocalReport> reports(pending.data(), count);
      auto parcel = std::make_unique<Parcel>();
      parcel->linearized_tick = parcel->at_tick = tick;
      std::vector<Vec3> places = places_in(reports.back());
      const double start = process_time_ms() - haptic_time_ms();
      parcel->model = run_.refresher.refresh(tick / run_.scene.local.rate_hz, places, reports,
                                             catches_up_ ? motion.get() : nullptr);
      run_.result.slow_cpu_ms.push_back(process_time_ms() - haptic_time_ms() - start);
      run_.refresher.charge(run_.result.slow_cpu_ms.back());
      interval_ = run_.refresher.next_interval(run_.ticks_per_refresh);
      pending.erase(pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(count));
      if (catches_up_) bring_near(*parcel, std::move(places), pending);
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

  /// CPU time of the haptic thread alone; when it is over, as it was last seen.
  double haptic_time_ms() {
    clockid_t clock{};
    timespec now{};
    if (pthread_getcpuclockid(haptic_handle_, &clock) == 0 && clock_gettime(clock, &now) == 0)
      haptic_ms_ = 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
    return haptic_ms_;
  }

  /// Checks some ticks of a local model that is not in use any more; without haste, but no more of them wait than there
  /// is memory for. True: there was something to do.
  bool look_at_past(int ticks) {
    if (auto parcel = used_.take(); parcel && parcel->model) past_.push_back(std::move(parcel->model));
    if (past_.size() > kMostWaiting) ticks = std::numeric_limits<int>::max();
    if (past_.empty() || ticks == 0) return false;
    if (!run_.haptic.look_at_past(*past_.front(), ticks)) past_.pop_front();
    return true;
  }

  void look_at_the_rest() {
    constexpr int kAll = std::numeric_limits<int>::max();
    while (look_at_past(kAll)) {
    }
    run_.haptic.look_at_past(run_.haptic.model(), kAll);
  }

  void receive(std::vector<LocalReport>& pending) {
    LocalReport item;
    while (up_.pop(item)) pending.push_back(item);
  }

  int num_nodes() const { return static_cast<int>(run_.refresher.state().x.size()) / 3; }

  std::vector<Vec3> places_in(const LocalReport& report) const {
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < turns_.size(); ++k) out.push_back(report.tools[k].place);
    return out;
  }

  /// Replays what the haptic loop has reported meanwhile, along the same sweeps as HapticLoop::catch_up; its own thread
  /// does the last few ticks.
  /// @param places  of the tools, where the model stands
  void bring_near(Parcel& parcel, std::vector<Vec3> places, std::vector<LocalReport>& pending) {
    const double h = 1 / run_.scene.local.rate_hz;
    std::vector<ToolSweep> sweeps(turns_.size());
    std::size_t next = 0;
    for (int round = 0; round < 8; ++round) {
      receive(pending);
      if (next == pending.size()) return;
      for (; next < pending.size(); ++next) {
        const LocalReport& report = pending[next];
        for (std::size_t k = 0; k < turns_.size(); ++k)
          sweeps[k] = turns_[k].sweep(places[k], report.tools[k].place, report.tick * h, (report.tick + 1) * h);
        catch_up_.step(parcel.model, sweeps);
        places = places_in(report);
        parcel.at_tick = report.tick + 1;
      }
    }
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
  bool catches_up_;
  CatchUp catch_up_;                                         // of the refresher's thread
  std::vector<ToolTurn> turns_;                              // of each tool
  int interval_;                                             // ticks to the next refresh
  std::unique_ptr<Parcel> arrived_;                          // of the haptic thread: not adopted yet
  Mailbox<LocalMotion> motion_, free_motion_;                // written; to be written over
  std::unique_ptr<LocalMotion> next_motion_;                 // of the haptic thread
  std::vector<std::unique_ptr<LocalMotion>> spare_motions_;  // of the refresher's thread
  std::deque<std::unique_ptr<PreparedLocalModel>> past_;     // whose ticks are not checked yet
  pthread_t haptic_handle_{};
  double haptic_ms_ = 0;
  std::vector<RefreshEvent> adopted_;
  std::vector<int> linearized_;
  std::atomic<bool> finished_{false}, stop_{false};
  int lost_reports_ = 0;
};

}  // namespace

void run_threads(const RunParts& run) { ThreadedRun(run).go(); }

}  // namespace kt
