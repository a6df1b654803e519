// The body in a thread of its own: models and reports are exchanged without locks, and each exchange is booked by tick,
// so that a lockstep replay repeats the run bit for bit.
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <limits>
#include <thread>

#include "core/base/cpu_time.hpp"
#include "core/base/ticks.hpp"
#include "haptics/touch/body_link.hpp"
#include "haptics/touch/report_list.hpp"
#include "haptics/touch/tick_end.hpp"

namespace kt {
namespace {

constexpr std::size_t kUsualReports = 4096;
constexpr int kAtOnce = 0, kBetween = 16;  // past ticks that are looked at: before a refresh; while none is due
constexpr std::size_t kMostWaiting = 8;    // local models whose ticks are not looked at yet
constexpr double kSoon = 0.002;            // [s] until the next refresh is due: the body asks for the motion
constexpr std::chrono::microseconds kWait{300};

class ThreadLink final : public BodyLink {
 public:
  ThreadLink(BodySide& body, HapticSide& side, const SurfaceFriction& friction, ModelObserver* observer)
      : body_(body),
        observer_(observer),
        ticks_(body.options(), observer),
        soon_(ticks_in(kSoon, body.options().local.rate_hz, 2)),
        run_in_(ticks_in(kRunIn, body.options().local.rate_hz)),
        catches_up_(catches_up(body.options())),
        catch_up_(shapes_of(body.options()), tick_length(body.options()), catch_up_solver(body.options(), friction)),
        interval_(ticks_per_refresh(body.options())) {
    body_.observe(observer);
    side.adopt(body_.refresh({0, 0}, side.poses(), {}, nullptr, [] { return 0.0; }));
    if (observer_) observer_->adopted(side.model());
    const int nodes = static_cast<int>(body_.state().x.size()) / 3;
    for (int i = 0; i < 3; ++i) spare_motions_.push_back(std::make_unique<LocalMotion>(make_local_motion(nodes)));
    thread_ = std::thread([this] { run(); });
  }
  ~ThreadLink() override { stop(); }

  void before_tick(HapticSide& side) noexcept override {
    if (side.next_tick() == 0) {
      clockid_t clock{};
      if (pthread_getcpuclockid(pthread_self(), &clock) == 0) ticking_clock_ = clock;
      put_body_before_others();
    }
    ticks_.before_tick(side);
  }

  void after_tick(HapticSide& side, const LocalReport& report) noexcept override { ticks_.after_tick(side, report); }

  void stop() override {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    while (look_back(std::numeric_limits<int>::max())) {
    }
    body_.finish();
  }
  std::exception_ptr error() const noexcept override { return has_failed_ ? error_ : nullptr; }
  bool has_failed() const noexcept override { return has_failed_.load(std::memory_order_acquire); }
  int lost_reports() const noexcept override { return ticks_.lost_reports(); }

 private:
  /// Where the ticks are before other programs, so is the body, after all that ticks: beside busy programs its models
  /// would come several times later. Round robin, lowest priority; what it starts inherits it. Else nothing.
  void put_body_before_others() noexcept {
    int policy = SCHED_OTHER;
    sched_param of_ticks{};
    if (pthread_getschedparam(pthread_self(), &policy, &of_ticks) != 0) return;
    const int lowest = sched_get_priority_min(SCHED_RR);
    if ((policy != SCHED_FIFO && policy != SCHED_RR) || of_ticks.sched_priority <= lowest) return;
    sched_param of_body{};
    of_body.sched_priority = lowest;
    pthread_setschedparam(thread_.native_handle(), SCHED_RR, &of_body);
  }

  void run() {
    try {
      while (!stop_) refresh_when_due();
    } catch (const std::exception& e) {
      error_ = std::current_exception();
      body_.failed(e.what());
      has_failed_.store(true, std::memory_order_release);
    }
  }

  /// The refresher always works for the latest moment that the haptic side has sent its motion of.
  void refresh_when_due() {
    const int due = last_ + body_.interval(interval_);
    const bool is_due =
        !pending_.empty() && (pending_.all().back().tick + soon_ >= due ||
                              (body_.options().global.early_refresh && pending_.all().back().left_patch));
    if (is_due && !spare_motions_.empty() && ticks_.ask_motion(spare_motions_.back())) spare_motions_.pop_back();
    if (auto newer = ticks_.take_motion()) {
      if (newest_) spare_motions_.push_back(std::move(newest_));
      newest_ = std::move(newer);
    }
    receive();
    look_back(kAtOnce);
    const int tick = newest_ ? newest_->tick : last_;
    const bool cannot_wait =
        body_.options().global.early_refresh &&
        std::ranges::any_of(pending_.all(), [&](const LocalReport& r) { return r.tick < tick && r.left_patch; });
    if (tick <= last_ || (tick < due && !cannot_wait)) {
      if (!look_back(kBetween)) std::this_thread::sleep_for(kWait);
      return;
    }
    std::size_t count = 0;
    const std::span<const LocalReport> waiting = pending_.all();
    while (count < waiting.size() && waiting[count].tick < tick) ++count;
    if (count == 0) {  // they were lost
      last_ = tick;
      return;
    }
    const std::span<const LocalReport> reports = waiting.first(count);
    auto parcel = std::make_unique<ModelParcel>();
    parcel->linearized_tick = parcel->at_tick = tick;
    const std::vector<Pose> at = poses_in(reports.back());
    const auto other_ms = [this] { return ticking_ms(); };
    if (catches_up_)
      parcel->model =
          body_.refresh(event_at(tick, reports), at, reports, newest_.get(), other_ms, [this] { ask_start(); });
    else
      parcel->model = body_.refresh(event_at(tick, reports), at, reports, nullptr, other_ms);
    body_.refresher().charge(body_.last_cpu_ms());
    interval_ = body_.refresher().next_interval(ticks_per_refresh(body_.options()));
    if (catches_up_) start(*parcel, count);
    pending_.drop(count);
    ticks_.put(std::move(parcel));
    last_ = tick;
  }

  /// Of the local model in use now: where the one that is nearly made goes on from. What lies there is older.
  void ask_start() {
    if (auto old = ticks_.take_motion()) spare_motions_.push_back(std::move(old));
    if (!spare_motions_.empty() && ticks_.ask_motion(spare_motions_.back())) spare_motions_.pop_back();
  }

  /// The new local model goes on from the motion that was asked for last, and is brought near the present: the ticking
  /// thread runs it in. Where nobody ticks, from that at its refresh.
  /// @param taken  reports that the refresh has taken
  void start(ModelParcel& parcel, std::size_t taken) {
    constexpr int kMostWaits = 20;
    std::unique_ptr<LocalMotion> now;
    for (int wait = 0; !now && wait < kMostWaits && !stop_; ++wait) {
      now = ticks_.take_motion();
      if (!now) std::this_thread::sleep_for(kWait);
    }
    receive();
    const LocalMotion& motion = now ? *now : *newest_;
    body_.start(motion, pending_.all().subspan(now ? taken : 0), *parcel.model);
    parcel.at_tick = motion.tick;
    parcel.run_in_tick = motion.tick + run_in_;
    replay(parcel);
    if (now) spare_motions_.push_back(std::move(now));
  }

  /// A refresh, with the ticks before it that have not reported: a replay leaves them out, too.
  RefreshEvent event_at(int tick, std::span<const LocalReport> reports) {
    RefreshEvent out{tick, -1};
    for (const LocalReport& report : reports) {
      for (; next_report_ < report.tick; ++next_report_) out.lost.push_back(next_report_);
      ++next_report_;
    }
    for (; next_report_ < tick; ++next_report_) out.lost.push_back(next_report_);
    return out;
  }

  /// CPU time of the thread that ticks; after its end, as it was told last.
  double ticking_ms() noexcept {
    const clockid_t clock = ticking_clock_;
    if (clock != 0) ticked_ms_ = std::max(ticked_ms_, clock_ms(clock));
    return ticked_ms_;
  }

  /// Looks at some ticks of a local model that is not in use any more; without haste, but no more of them wait than
  /// there is memory for. True: there was something to do.
  bool look_back(int ticks) {
    if (auto parcel = ticks_.take_used(); parcel && parcel->model) {
      body_.adopted(parcel->linearized_tick, parcel->adopted_tick, parcel->model.get());
      if (observer_) past_.push_back(std::move(parcel->model));
    }
    if (past_.size() > kMostWaiting) ticks = std::numeric_limits<int>::max();
    if (past_.empty() || ticks == 0) return false;
    if (!observer_->look_back(*past_.front(), ticks)) past_.pop_front();
    return true;
  }

  /// What is there; not what comes meanwhile, or a thread that gets little of the processor does nothing else.
  void receive() {
    for (std::size_t n = ticks_.reports().size(); n > 0 && ticks_.reports().pop(pending_.next()); --n)
      pending_.keep_next();
  }

  std::vector<Pose> poses_in(const LocalReport& report) const {
    std::vector<Pose> out;
    for (std::size_t k = 0; k < body_.options().tools.size(); ++k) out.push_back(report.tools[k].pose);
    return out;
  }

  /// Replays what the haptic side has reported since the model's start, along the same sweeps as HapticSide::catch_up;
  /// its own thread does the rest. Where one was lost, too: it has its own record.
  void replay(ModelParcel& parcel) {
    receive();
    std::vector<ToolSweep> sweeps(body_.options().tools.size());
    const std::span<const LocalReport> reports = pending_.all();
    auto before = std::ranges::lower_bound(reports, parcel.at_tick - 1, {}, &LocalReport::tick);
    for (; before != reports.end() && before->tick == parcel.at_tick - 1; ++before, ++parcel.at_tick) {
      const auto next = before + 1;
      if (next == reports.end() || next->tick != parcel.at_tick) break;
      for (std::size_t k = 0; k < sweeps.size(); ++k) sweeps[k] = {before->tools[k].pose, next->tools[k].pose};
      catch_up_.step(*parcel.model, sweeps);
    }
  }

  BodySide& body_;
  ModelObserver* observer_;
  TickEnd ticks_;
  int soon_, run_in_;  // ticks
  bool catches_up_;
  CatchUp catch_up_;                                         // of the body's thread
  int interval_, last_ = 0;                                  // ticks to the next refresh; of the last one
  int next_report_ = 0;                                      // tick of the first one that no refresh has taken
  ReportList pending_{kUsualReports};                        // not taken into a refresh yet
  std::unique_ptr<LocalMotion> newest_;                      // of the body's thread
  std::vector<std::unique_ptr<LocalMotion>> spare_motions_;  // of the body's thread
  std::deque<std::unique_ptr<PreparedLocalModel>> past_;     // whose ticks are not looked at yet
  std::atomic<clockid_t> ticking_clock_{0};
  double ticked_ms_ = 0;  // of the body's thread
  std::atomic<bool> stop_{false}, has_failed_{false};
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<BodyLink> make_thread_link(BodySide& body, HapticSide& side, const SurfaceFriction& friction,
                                           ModelObserver* observer) {
  return std::make_unique<ThreadLink>(body, side, friction, observer);
}

}  // namespace kt
