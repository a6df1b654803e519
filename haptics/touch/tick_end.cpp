#include "haptics/touch/tick_end.hpp"

#include "core/base/ticks.hpp"

namespace kt {
namespace {

constexpr double kLongest = 1;                                // [s] that a refresh may take: reports wait for it
constexpr int kFewestReports = 4096, kMostReports = 1 << 15;  // each 5 KB

/// Past ticks that a new local model catches up with in one of the present, which is to keep its period: each takes as
/// long as one. With fewer it never gets there.
constexpr int kMostCaughtUp = 2;

}  // namespace

TickEnd::TickEnd(const TouchOptions& options, ModelObserver* observer)
    : observer_(observer),
      catches_up_(catches_up(options)),
      reports_(static_cast<std::size_t>(ticks_in(kLongest, options.local.rate_hz, kFewestReports, kMostReports))) {}

void TickEnd::before_tick(HapticSide& side) noexcept {
  // A model is taken only when the used one can be handed back: freeing is not for this thread.
  if (!arrived_ && used_.is_empty()) arrived_ = down_.take();
  if (!arrived_ || (catches_up_ && !side.catch_up(arrived_->model, arrived_->at_tick, kMostCaughtUp))) return;
  if (side.next_tick() < arrived_->run_in_tick) return;
  arrived_->adopted_tick = side.next_tick();
  arrived_->model = side.adopt(std::move(arrived_->model));
  if (observer_) observer_->adopted(side.model());
  used_.put(std::move(arrived_));
}

void TickEnd::after_tick(HapticSide& side, const LocalReport& report) noexcept {
  if (!reports_.push(report)) lost_reports_.fetch_add(1, std::memory_order_relaxed);
  send_motion(side);
}

/// The refresher goes on from here, when it has asked for that; what it has not read is written over.
void TickEnd::send_motion(HapticSide& side) noexcept {
  if (!next_motion_) next_motion_ = free_motion_.take();
  if (!next_motion_) return;
  side.record_motion(*next_motion_);
  next_motion_ = motion_.put(std::move(next_motion_));
}

}  // namespace kt
