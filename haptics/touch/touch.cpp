#include "haptics/touch/touch.hpp"

#include <algorithm>
#include <cmath>

#include "haptics/scene_friction.hpp"

namespace kt {
namespace {

constexpr int kShapeEvery = 16;  // ticks between two shapes for pictures

TouchOptions checked(TouchOptions options) {
  check_options(options);
  return options;
}

SurfaceFriction friction_of(const Body& body, const TouchOptions& options) {
  std::vector<std::string> none;
  return scene_friction(options.contact, body.surface(), body.model().mesh().x, none);
}

}  // namespace

Touch::Touch(const Body& body, TouchOptions options)
    : body_(body),
      options_(checked(std::move(options))),
      friction_(friction_of(body, options_)),
      haptic_(options_, friction_) {
  const double slow = std::max(options_.stale_s, 4 / options_.global.rate_hz) + 1e-3 * options_.link.latency_ms;
  stale_ticks_ = static_cast<int>(std::llround(slow * options_.local.rate_hz));
  side_ = std::make_unique<BodySide>(body_, options_);
}

Touch::~Touch() = default;

void Touch::place(std::span<const Pose> tools) {
  if (tools.size() != haptic_.num_tools())
    throw InputError(text("place: ", tools.size(), " poses for ", haptic_.num_tools(), " tools"));
  if (link_) throw InputError("place: after the first tick; tools are where the ticks have them");
  for (const Pose& pose : tools)
    if (!pose.is_finite()) throw InputError("place: a pose that is not finite");
  haptic_.place(tools);
  is_placed_ = true;
}

void Touch::start() {
  if (link_) throw InputError("start: after the first tick, or twice");
  options_.link.type = "thread";
  side_ = std::make_unique<BodySide>(body_, options_);
  link_ = make_thread_link(*side_, haptic_, friction_, observer_);
}

void Touch::stop() {
  if (!link_) return;
  link_->stop();
  if (link_->error()) std::rethrow_exception(link_->error());
}

void Touch::refresh_if_due() noexcept {
  if (!link_) link_ = make_lockstep_link(*side_, observer_);
  link_->before_tick(haptic_);
}

std::span<const LocalFrame> Touch::tick(std::span<const Pose> tools) noexcept {
  const std::span<LocalFrame> frames(frames_.data(), haptic_.num_tools());
  if (tools.size() < frames.size()) return frames;  // wrong use: nothing happens
  if (!is_placed_) haptic_.place(tools);
  is_placed_ = true;
  refresh_if_due();
  const LocalReport& report = haptic_.tick(tools, frames);
  link_->after_tick(haptic_, report);
  unsigned flags = link_->has_failed() ? kBodyFailed : 0u;
  if (haptic_.has_model() && haptic_.next_tick() - haptic_.model_tick() > stale_ticks_) flags |= kStaleModel;
  if (flags != 0)
    for (LocalFrame& frame : frames) frame.flags |= flags;
  if (observer_) observer_->ticked(haptic_, frames);
  if (is_watched_.load(std::memory_order_relaxed) && haptic_.next_tick() % kShapeEvery == 0) show_shape();
  return frames;
}

std::span<const LocalFrame> Touch::tick(std::span<const Pose> tools, double dt) noexcept {
  const std::span<LocalFrame> frames(frames_.data(), haptic_.num_tools());
  if (tools.size() < frames.size()) return frames;
  if (!is_placed_) return tick(tools);
  if (std::isfinite(dt) && dt > 0) owed_ += dt;
  const double steps = std::floor(owed_ / h() + 0.5);
  owed_ -= steps * h();
  const int count = static_cast<int>(std::min<double>(steps, kMostSteps));
  std::array<Pose, kMaxTools> from, at;
  for (std::size_t k = 0; k < frames.size(); ++k) from[k] = haptic_.poses()[k];
  for (int i = 1; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      at[k] = tools[k];
      if (i < count) at[k] = {from[k].x + share * (tools[k].x - from[k].x), from[k].r.slerp(share, tools[k].r)};
    }
    tick(std::span<const Pose>(at.data(), frames.size()));
  }
  if (steps > count)
    for (LocalFrame& frame : frames) frame.flags |= kLateTick;
  return frames;
}

void Touch::show_shape() noexcept {
  if (!haptic_.has_model()) return;
  if (!next_shape_) next_shape_ = free_shape_.take();
  if (!next_shape_) return;
  haptic_.record_motion(*next_shape_);
  next_shape_ = shape_.put(std::move(next_shape_));
}

void Touch::copy_positions(VectorX& x) {
  const std::scoped_lock lock(watching_);
  side_->copy_positions(x);
  const int nodes = static_cast<int>(x.size()) / 3;
  if (!is_watched_.load(std::memory_order_relaxed)) {
    free_shape_.put(std::make_unique<LocalMotion>(make_local_motion(nodes)));
    shown_ = std::make_unique<LocalMotion>(make_local_motion(nodes));
    is_watched_.store(true, std::memory_order_release);
  }
  if (auto newer = shape_.take()) {
    free_shape_.put(std::move(shown_));
    shown_ = std::move(newer);
  }
  for (int i = 0; i < nodes; ++i)
    if (const int row = shown_->row[i]; row >= 0) node(x, i) = node(shown_->x, row);
}

}  // namespace kt
