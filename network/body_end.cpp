#include "network/body_end.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "haptics/refresh/touch_parts.hpp"
#include "haptics/remote/model_unpacker.hpp"

namespace kt {
namespace {

constexpr std::size_t kMostBatches = 4096;  // of a body that takes seconds for a refresh: the sums say the rest
constexpr std::size_t kMostKept = 256, kAges = 20;

TouchOptions sendable(TouchOptions options) {
  require_sendable(options);
  return options;
}

}  // namespace

BodyEnd::BodyEnd(const Body& body, TouchOptions options, ModelObserver* observer)
    : h_(tick_length(options)),
      side_(body, sendable(options)),
      inbox_(h_),
      due_(ticks_per_refresh(options)),
      interval_(due_),
      usual_(interval_) {
  side_.observe(observer);
}

ModelMessage BodyEnd::begin(std::span<const Pose> tools) {
  return packed(*side_.refresh({0, 0}, tools, {}, nullptr, [] { return 0.0; }));
}

ModelMessage BodyEnd::packed(const PreparedLocalModel& model) {
  ModelMessage out{.model = pack_model(model, side_.options().link.basis_bits)};
  const TouchStatus status = side_.status();
  out.expected_force_error = status.expected_force_error;
  out.force_factor = status.force_factor;
  out.refresh_ms = status.refresh_ms;
  kept_[model.model.frame] = {model.linearized_tick, static_cast<int>(model.model.recovered_node.size()),
                              model.model.patch.num_vertices(), model.recovered_row};
  while (kept_.size() > kMostKept) kept_.erase(kept_.begin());
  const std::scoped_lock lock(guard_);
  ++counts_.models;
  return out;
}

void BodyEnd::take(ReportMessage message) {
  const std::scoped_lock lock(guard_);
  ++counts_.reports;
  loss_ = message.loss;
  last_report_ = message.batch.reports.back();
  if (batches_.size() < kMostBatches) batches_.push_back(std::move(message.batch));
  came_.notify_one();
}

void BodyEnd::take(MotionMessage message) {
  const std::scoped_lock lock(guard_);
  ++counts_.motions;
  loss_ = message.reports.loss;
  if (!motion_ || message.motion.tick > motion_->motion.tick) {
    motion_ = std::move(message);
    motion_came_ = std::chrono::steady_clock::now();
  }
  came_.notify_one();
}

void BodyEnd::wait(std::chrono::milliseconds most) {
  std::unique_lock lock(guard_);
  came_.wait_for(lock, most, [&] { return !batches_.empty() || motion_; });
}

/// Which local model the ticks use.
void BodyEnd::follow_adoption(const ReportBatch& batch) {
  if (batch.adopted_frame <= adopted_frame_) return;
  const auto kept = kept_.find(batch.adopted_frame);
  if (kept == kept_.end()) return;
  const int before = std::exchange(adopted_frame_, batch.adopted_frame);
  constexpr double kOldest = 60;  // [s] what is told to be older counts as that
  age_ = std::clamp(batch.adopted_tick - kept->second.linearized_tick, 0, static_cast<int>(kOldest / h_));
  ages_.push_back(age_);
  if (ages_.size() > kAges) ages_.pop_front();
  side_.adopted(kept->second.linearized_tick, batch.adopted_tick, nullptr);
  kept_.erase(kept_.begin(), kept_.lower_bound(before));  // a motion of the one before may wait here still
}

/// Nine of ten local models were not older when they were taken [ticks]; -1: too few were taken yet.
int BodyEnd::expected_age() const {
  constexpr std::size_t kFew = 3;
  if (ages_.size() < kFew) return -1;
  std::vector<int> sorted(ages_.begin(), ages_.end());
  const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(9 * (sorted.size() - 1) / 10);
  std::ranges::nth_element(sorted, place);
  return *place;
}

std::optional<ModelMessage> BodyEnd::refresh_if_due() {
  std::optional<MotionMessage> motion;
  std::chrono::steady_clock::time_point came;
  {
    const std::scoped_lock lock(guard_);
    came = motion_came_;
    for (const ReportBatch& batch : batches_) {
      inbox_.take(batch);
      follow_adoption(batch);
    }
    batches_.clear();
    motion.swap(motion_);
  }
  if (!motion) return {};
  // At the edge of the patch sooner; but no more models than can be known to help: four in a round trip.
  const bool wants_now =
      side_.options().global.early_refresh && (inbox_.is_at_edge() || motion->reports.batch.reports.back().left_patch);
  const int least = std::max({1, usual_ / 8, age_ / 4});
  const int tick = motion->motion.tick;
  if (tick < due_ && !(wants_now && tick >= last_ + least)) return {};
  follow_adoption(motion->reports.batch);
  const auto kept = kept_.find(motion->frame);
  if (kept == kept_.end() || kept->second.recovered != motion->recovered || kept->second.patch != motion->patch) {
    const std::scoped_lock lock(guard_);
    ++counts_.misfits;
    return {};
  }
  const std::span<const LocalReport> reports = inbox_.close(motion->reports.batch);
  if (reports.empty()) return {};
  LocalMotion from = std::move(motion->motion);
  from.row = kept->second.row;
  from.num_patch = motion->patch;
  std::vector<Pose> at;
  for (std::size_t k = 0; k < side_.options().tools.size(); ++k) at.push_back(reports.back().tools[k].pose);
  const RefreshEvent event{tick, -1, tick, expected_age(), inbox_.lost()};
  if (event.delay_ticks >= 0) side_.expect(event.delay_ticks * h_);
  const auto model = side_.refresh(event, at, reports, &from, [] { return 0.0; });
  side_.refresher().charge(side_.last_cpu_ms());
  interval_ = side_.refresher().next_interval(usual_);
  last_ = tick;
  // Motions come a few times an interval: what one was late for the next one is not.
  due_ = tick >= due_ && tick < due_ + interval_ ? due_ + interval_ : tick + interval_;
  {
    const std::scoped_lock lock(guard_);
    counts_.inbox = inbox_.counts();
  }
  ModelMessage out = packed(*model);
  out.body_ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - came).count();
  return out;
}

void BodyEnd::set(const SettingChange& change) {
  if (change.word.empty())
    side_.set(change.key, change.value);
  else
    side_.set(change.key, change.word);
}

std::optional<double> BodyEnd::model_loss() const {
  const std::scoped_lock lock(guard_);
  return loss_;
}

BodyEndCounts BodyEnd::counts() const {
  const std::scoped_lock lock(guard_);
  return counts_;
}

LocalReport BodyEnd::last_report() const {
  const std::scoped_lock lock(guard_);
  return last_report_;
}

}  // namespace kt
