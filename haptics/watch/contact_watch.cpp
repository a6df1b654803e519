#include "haptics/watch/contact_watch.hpp"

#include <algorithm>
#include <limits>

#include "core/base/error.hpp"

namespace kt {

constexpr std::size_t kRecorded = std::size_t{1} << 21;  // numbers at 1 kHz: thousands of ticks of a usual local model
constexpr double kMostTimes = 4;                         // at faster rates

ContactWatch::ContactWatch(const Surface& surface, std::span<const ToolShape> tools, bool later, double h, bool keeps)
    : tools_(tools.size()),
      keeps_(keeps),
      check_(surface, tools),
      record_(later ? std::make_unique<MotionRecord>(static_cast<std::size_t>(std::clamp(1e-3 / h, 1.0, kMostTimes)) *
                                                     kRecorded)
                    : nullptr) {}

void ContactWatch::adopted(const PreparedLocalModel& model) noexcept {
  if (!record_) check_.take(model);
}

void ContactWatch::ticked(const HapticSide& side, std::span<const LocalFrame> frames) noexcept {
  if (!side.has_model()) return;
  MotionRecord::Tick tick{side.next_tick() - 1, side.model().model.frame, {}};
  for (std::size_t k = 0; k < tools_; ++k) {
    const ToolSweep sweep = side.last_sweep(k);
    tick.tools[k] = {
        {sweep.x_t0, sweep.r_t0}, {sweep.x_t1, sweep.r_t1}, frames[k].mode == ContactMode::free, frames[k].gap};
  }
  const LocalState& s = side.model().state;
  if (!record_)
    look(tick, (VectorX(s.q.size() + s.yielded.size()) << s.q, s.yielded).finished());
  else if (!record_->push(tick, s.q, {s.yielded.data(), static_cast<std::size_t>(s.yielded.size())}))
    unnoted_.fetch_add(1, std::memory_order_relaxed);
}

LostContact ContactWatch::lost(std::size_t tool) const {
  LostContact out = lost_[tool];
  if (tool == 0) out.unchecked_ticks += unnoted_.load(std::memory_order_relaxed);
  return out;
}

/// False: there is no room for it, which who records the ticks tells.
bool ContactWatch::note_depth(std::size_t tool, int tick, double depth) try {
  LostContact& lost = lost_[tool];
  lost.deepest = std::max(lost.deepest, depth);
  lost.deep_ticks += depth > LostContact::kNoticeableDepth;
  if (!keeps_) return true;
  penetration_[tool].resize(static_cast<std::size_t>(tick) + 1, 0.0);
  penetration_[tool].back() = depth;
  return true;
} catch (const RunError&) {
  return false;
}

/// With the model that was in use.
/// @param q  its coordinates at the end of the tick, and what the points of a fine patch had yielded by
void ContactWatch::look(const MotionRecord::Tick& tick, const VectorX& q) {
  check_.place(q);
  for (std::size_t k = 0; k < tools_; ++k) {
    const MotionRecord::Way& way = tick.tools[k];
    LostContact& lost = lost_[k];
    const int tool = static_cast<int>(k);
    const double depth = check_.depth(tool, way.sweep());
    if (!note_depth(k, tick.tick, depth)) {
      ++lost.unchecked_ticks;
      continue;
    }
    if (way.is_free && depth > BodyCheck::kInside) {
      ++lost.free_ticks_inside;
    } else if (way.is_free ? check_.went_through(tool, way.sweep())
                           : check_.leapt_into(tool, way.sweep(), std::max(depth, -way.gap))) {
      ++lost.pass_throughs;
      if (lost.went_through.size() < LostContact::kMostNamed)
        lost.went_through.push_back({tick.tick, (way.to.x - way.from.x).norm()});
    }
  }
}

bool ContactWatch::look_back(const PreparedLocalModel& model, int most) {
  for (int i = 0; i < most; ++i) {
    MotionRecord::Tick tick;
    if (!record_ || !record_->front(tick, past_q_) || tick.frame != model.model.frame) return false;
    if (past_frame_ != tick.frame) check_.take(model);
    past_frame_ = tick.frame;
    look(tick, past_q_);
    record_->pop();
  }
  return true;
}

void ContactWatch::finish(const PreparedLocalModel& model) { look_back(model, std::numeric_limits<int>::max()); }

}  // namespace kt
