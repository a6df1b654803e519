#include "haptics/halves/haptic_side.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/ticks.hpp"

namespace kt {
namespace {

constexpr double kFarthest = 1e6;  // [m], as places in a scene

/// Ticks that a model may be late and still be brought to the present. A replay does at once what the body's thread did
/// from its reports, however late it was.
std::size_t history_ticks(const TouchOptions& options) {
  constexpr double kUsual = 4.096;  // [s]
  int usual = ticks_in(kUsual, options.local.rate_hz, 4096, 1 << 18);
  for (const RefreshEvent& e : options.replay.refreshes)
    usual = std::max(usual, e.adopted_tick - std::min(e.linearized_tick, e.started_tick) + 1);
  return static_cast<std::size_t>(usual) +
         static_cast<std::size_t>(std::llround(1e-3 * options.link.latency_ms * options.local.rate_hz)) +
         static_cast<std::size_t>(ticks_per_refresh(options));
}

}  // namespace

bool is_usable(const Pose& pose) noexcept {
  return pose.is_finite() && pose.x.lpNorm<Eigen::Infinity>() <= kFarthest && pose.r.squaredNorm() > 0.5 &&
         pose.r.squaredNorm() < 2;
}

HapticSide::HapticSide(const TouchOptions& options, const SurfaceFriction& friction)
    : local_(make_method(options, friction)),
      catch_up_(shapes_of(options), tick_length(options), catch_up_solver(options, friction)),
      poses_(options.tools.size()),
      history_(options.tools.size(), history_ticks(options)) {}

/// Quaternions that are long or short would stretch the tool. Those of unit length but for rounding stay as they are.
static Pose with_unit_turn(Pose pose) noexcept {
  constexpr double kRounding = 1e-12;
  if (std::abs(pose.r.squaredNorm() - 1) > kRounding) pose.r.normalize();
  return pose;
}

void HapticSide::place(std::span<const Pose> tools) noexcept {
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    poses_[k] = with_unit_turn(tools[k]);
    history_.put(tick_, k, poses_[k]);
  }
}

const LocalReport& HapticSide::tick(std::span<const Pose> tools, std::span<LocalFrame> frames) noexcept {
  const std::size_t count = poses_.size();
  std::array<ToolSweep, kMaxTools> sweeps;
  std::array<unsigned, kMaxTools> flags{};
  for (std::size_t k = 0; k < count; ++k) {
    if (is_usable(tools[k]))
      poses_[k] = with_unit_turn(tools[k]);
    else
      flags[k] = kBadPose;
    history_.put(tick_ + 1, k, poses_[k]);
    sweeps[k] = history_.sweep(tick_, k);
  }
  report_.count = 0;
  report_.left_patch = false;
  if (has_model_) {
    local_->step_tools(std::span(sweeps).first(count), frames.first(count));
    report_.model_frame = local_->model().model.frame;
    for (const TickContact& sample : local_->samples()) report_.samples[report_.count++] = sample;
  } else {
    for (LocalFrame& frame : frames) frame = {};
    flags.fill(kNoModel);
  }
  for (std::size_t k = 0; k < count; ++k) {
    LocalFrame& frame = frames[k];
    frame.t = (tick_ + 1) * h();
    frame.pose = poses_[k];
    frame.flags |= flags[k];
    // Whatever the method: a torque or a part of the force that is no number leaves nobody.
    if (!(frame.force.allFinite() && frame.torque.allFinite() && std::isfinite(frame.f_n + frame.f_t))) {
      frame.force.setZero();
      frame.torque.setZero();
      frame.f_n = frame.f_t = 0;
      frame.flags |= kNotFinite;
    }
    const bool touches =
        std::ranges::any_of(report_.contacts(), [&](const TickContact& s) { return s.tool == static_cast<int>(k); });
    report_.tools[k] = {poses_[k], touches ? frame.triangle : -1,  // where it touches, whatever force is shown
                        frame.mode == ContactMode::frictional_slide};
    report_.left_patch = report_.left_patch || (frame.flags & kLeftPatch) != 0;
  }
  report_.tick = tick_++;
  return report_;
}

LocalReport HapticSide::past_report(int ticks) const noexcept {
  const int back = std::min({ticks, tick_, history_.reach()});
  LocalReport out;
  out.tick = tick_ - 1 - back;
  for (std::size_t k = 0; k < poses_.size(); ++k) out.tools[k].pose = history_.get(tick_ - back, k);
  return out;
}

bool HapticSide::catch_up(std::unique_ptr<PreparedLocalModel>& model, int& at, int most) noexcept {
  std::array<ToolSweep, kMaxTools> sweeps;
  if (tick_ - at > history_.reach()) return true;  // too old: taken as it is
  for (int i = 0; i < most && at < tick_; ++i, ++at) {
    for (std::size_t k = 0; k < poses_.size(); ++k) sweeps[k] = history_.sweep(at, k);
    catch_up_.step(*model, std::span(sweeps).first(poses_.size()));
  }
  model->caught_up = at == tick_;
  return model->caught_up;
}

std::unique_ptr<PreparedLocalModel> HapticSide::adopt(std::unique_ptr<PreparedLocalModel> model) noexcept {
  has_model_ = true;
  model_tick_ = model->linearized_tick;
  adopted_tick_ = tick_;
  PreparedLocalModel* const in_use = model.get();
  std::unique_ptr<PreparedLocalModel> old = local_->adopt(std::move(model));
  // With the state that it begins with here: nothing is allocated, they are as long.
  if (&local_->model() == in_use && in_use->adopted_q.size() == in_use->state.q.size())
    in_use->adopted_q = in_use->state.q;
  return old;
}

void HapticSide::lay_patch_over(VectorX& out) const {
  const PreparedLocalModel& m = local_->model();
  const VectorX x = m.model.x0 + m.model.basis * m.state.q;
  for (int i = 0; i < static_cast<int>(m.model.recovered_node.size()); ++i)
    node(out, m.model.recovered_node[i]) = node(x, i);
}

}  // namespace kt
