#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "core/base/cpu_time.hpp"
#include "core/base/ticks.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "haptics/remote/report_box.hpp"
#include "haptics/remote/yield_memory.hpp"
#include "haptics/touch/body_link.hpp"
#include "haptics/touch/report_list.hpp"

namespace kt {
namespace {

constexpr std::size_t kMostReports = 8192;  // of slower rates the first interval makes room for the others

/// A local model on its way.
struct Parcel {
  int linearized_tick = 0, due_tick = 0, at_tick = 0;  ///< when it arrives; where its state stands
  std::unique_ptr<PreparedLocalModel> model;
};

/// When the body is refreshed, and which local models arrive: from the settings, or as it was in the run that is
/// replayed.
class Schedule {
 public:
  explicit Schedule(const TouchOptions& options)
      : options_(options),
        latency_(static_cast<int>(std::llround(options.link.latency_ms * 1e-3 * options.local.rate_hz))),
        run_in_(ticks_in(kRunIn, options.local.rate_hz)),
        random_(options.seed) {}

  bool is_replayed() const { return !options_.replay.refreshes.empty(); }

  bool is_due(int tick, bool wanted_now) const {
    const std::vector<RefreshEvent>& replayed = options_.replay.refreshes;
    if (is_replayed()) return next_ < replayed.size() && replayed[next_].linearized_tick == tick;
    const int least =
        std::max(1, ticks_per_refresh(options_) / 8);  // a slow side that is asked every tick does nothing else
    return tick >= busy_until_ && (tick >= due_ || (wanted_now && tick >= last_ + least));
  }

  /// Ticks whose reports do not arrive before the next refresh.
  bool is_lost(int tick) const {
    const std::vector<RefreshEvent>& replayed = options_.replay.refreshes;
    return is_replayed() && next_ < replayed.size() && std::ranges::binary_search(replayed[next_].lost, tick);
  }

  RefreshEvent take(int tick) {
    last_ = tick;
    if (is_replayed()) return options_.replay.refreshes[next_++];
    // 53 random bits: the same on every standard library, which uniform_real_distribution is not.
    const bool lost = static_cast<double>(random_() >> 11) * 0x1p-53 < options_.link.loss;
    const bool first = tick == 0;  // the set-up model is there before the first tick
    return {tick, first ? 0 : lost ? -1 : tick + latency_};
  }

  void set_next(int tick) { due_ = std::max(tick, busy_until_); }

  /// A higher rate has been set since: the next one comes sooner than planned.
  void hurry(const BodySide& body) { due_ = std::min(due_, last_ + body.interval(due_ - last_)); }

  /// The slow side takes that many ticks for the refresh that begins at this one: it does nothing else meanwhile, and
  /// its local model is as late.
  void charge(int tick, int ticks, RefreshEvent& event) {
    busy_until_ = tick + ticks;
    if (event.adopted_tick >= 0) event.adopted_tick += ticks;
  }

  /// The next local model, when it comes as planned, starts from the motion at this tick.
  bool is_start(int tick) const {
    const std::vector<RefreshEvent>& replayed = options_.replay.refreshes;
    if (is_replayed()) return next_ < replayed.size() && replayed[next_].started_tick == tick;
    if (models_come_late(options_)) return false;  // later than it takes to run in
    return tick == std::max(last_ + 1, due_ - std::max(0, run_in_ - latency_));
  }

 private:
  const TouchOptions& options_;
  int latency_, run_in_, due_ = 0, last_ = 0, busy_until_ = 0;
  std::size_t next_ = 0;
  std::mt19937_64 random_;
};

/// Where the tools were last told to be: where reports were lost, not where they are.
std::vector<Pose> places(std::span<const LocalReport> reports, std::span<const Pose> start) {
  std::vector<Pose> out(start.begin(), start.end());
  if (!reports.empty())
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = reports.back().tools[k].pose;
  return out;
}

/// What a network makes of the values that go over it: a run that was made over one has the same bits again.
class AsOverNetwork {
 public:
  AsOverNetwork(const Body& body, const TouchOptions& options)
      : outbox_(1, tick_length(options)),
        inbox_(tick_length(options)),
        unpacker_(body, options),
        bits_(options.link.basis_bits) {}
  void add(const LocalReport& report, bool is_lost) {
    outbox_.add(report);
    if (!is_lost) inbox_.take(outbox_.batch(1));
  }
  std::span<const LocalReport> reports() {
    if (outbox_.empty()) return {};
    return inbox_.close(outbox_.batch(1));
  }
  void note(const LocalMotion& motion) { yields_.note(motion); }
  std::unique_ptr<PreparedLocalModel> carry(const PreparedLocalModel& model) {
    auto out = unpacker_.unpack(pack_model(model, bits_));
    yields_.add(*out);
    yields_.start(*out, out->linearized_tick);
    return out;
  }

 private:
  ReportOutbox outbox_;
  ReportInbox inbox_;
  ModelUnpacker unpacker_;
  YieldMemory yields_;
  int bits_;
};

class LockstepLink final : public BodyLink {
 public:
  LockstepLink(BodySide& body, ModelObserver* observer)
      : body_(body),
        observer_(observer),
        schedule_(body.options()),
        reports_(std::min<std::size_t>(kMostReports, 2 * static_cast<std::size_t>(ticks_per_refresh(body.options())))),
        motion_(make_local_motion(static_cast<int>(body.state().x.size()) / 3)),
        catches_up_(catches_up(body.options())) {
    body_.observe(observer);
    if (body.options().link.type == "network") network_.emplace(body.body(), body.options());
  }

  void before_tick(HapticSide& side) noexcept override {
    const int tick = side.next_tick();
    if (error_ || tick == prepared_) return;
    prepared_ = tick;
    try {
      start_waiting(side, tick);
      refresh_if_due(side, tick);
    } catch (const std::exception& e) {
      error_ = std::current_exception();
      body_.failed(e.what());
      return;
    }
    while (!on_the_way_.empty() && on_the_way_.front().due_tick <= tick) {
      Parcel& parcel = on_the_way_.front();
      if (catches_up_) side.catch_up(parcel.model, parcel.at_tick, tick);
      const std::unique_ptr<PreparedLocalModel> old = side.adopt(std::move(parcel.model));
      body_.adopted(parcel.linearized_tick, parcel.due_tick, old.get());
      if (observer_ && old) observer_->look_back(*old, std::numeric_limits<int>::max());
      if (observer_) observer_->adopted(side.model());
      on_the_way_.pop_front();
    }
    if (tick > 0 && catches_up_ && schedule_.is_start(tick)) {
      side.record_motion(motion_);
      has_start_ = true;
    }
  }

  void after_tick(HapticSide&, const LocalReport& report) noexcept override {
    if (error_) return;
    if (network_)
      network_->add(report, schedule_.is_lost(report.tick));
    else if (!schedule_.is_lost(report.tick))
      reports_.add(report);
  }
  void stop() override { body_.finish(); }
  std::exception_ptr error() const noexcept override { return error_; }
  bool has_failed() const noexcept override { return error_ != nullptr; }

 private:
  /// A run in two threads that is replayed: its local models go on from a motion after their refresh.
  void start_waiting(HapticSide& side, int tick) {
    for (Parcel& parcel : on_the_way_)
      if (parcel.linearized_tick < tick && parcel.at_tick == tick) {
        side.record_motion(motion_);
        body_.start(motion_, reports_.all(), *parcel.model);
      }
  }

  void refresh_if_due(HapticSide& side, int tick) {
    const TouchOptions& options = body_.options();
    // At the edge of the patch, a new one is asked for once; the answer takes its time.
    const bool wanted =
        !reports_.empty() && reports_.all().back().left_patch && on_the_way_.empty() && options.global.early_refresh;
    schedule_.hurry(body_);
    if (!schedule_.is_due(tick, wanted)) return;
    RefreshEvent event = schedule_.take(tick);
    const bool goes_on = tick > 0 && catches_up_;
    if (goes_on && !has_start_) side.record_motion(motion_);
    const bool starts_later = goes_on && !network_ && event.started_tick > tick;
    if (goes_on && !starts_later) event.started_tick = motion_.tick;
    has_start_ = false;
    const double predicted_ms = tick > 0 ? body_.refresher().choice().predicted_refresh_ms() : 0;
    const std::span<const LocalReport> reports = network_ ? network_->reports() : reports_.all();
    if (network_ && goes_on) {
      network_->note(motion_);
      round_as_sent(motion_);
    }
    if (network_ && event.delay_ticks >= 0) body_.expect(event.delay_ticks * side.h());
    auto model = body_.refresh(
        event, places(reports, side.poses()), reports, goes_on ? &motion_ : nullptr, [] { return 0.0; },
        starts_later ? std::function([] {}) : std::function<void()>());
    if (network_) model = network_->carry(*model);
    const double took_ms = body_.last_cpu_ms();
    if (!schedule_.is_replayed() && tick > 0) {
      schedule_.charge(tick, charged_ticks(options, took_ms, predicted_ms), event);
      body_.reschedule(event);
      if (models_come_late(options)) body_.refresher().charge(charged_ms(options, took_ms, predicted_ms));
    }
    reports_.clear();
    schedule_.set_next(tick + body_.refresher().next_interval(ticks_per_refresh(options)));
    if (event.adopted_tick >= 0)
      on_the_way_.push_back({tick, event.adopted_tick, event.started_tick, std::move(model)});
  }

  BodySide& body_;
  ModelObserver* observer_;
  Schedule schedule_;
  std::deque<Parcel> on_the_way_;
  ReportList reports_;
  std::optional<AsOverNetwork> network_;  // instead of reports_
  LocalMotion motion_;
  bool catches_up_, has_start_ = false;
  int prepared_ = -1;
  std::exception_ptr error_;
};

}  // namespace

std::unique_ptr<BodyLink> make_lockstep_link(BodySide& body, ModelObserver* observer) {
  return std::make_unique<LockstepLink>(body, observer);
}

}  // namespace kt
