#include "haptics/guard/safety_chain.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr double kUsualForce = 3;     // [N] of a live device that says nothing: a firm push of a finger
constexpr double kUsualTorque = 0.1;  // [N m] the same
constexpr double kOldest = 5e-3;      // [s] of a pose
constexpr double kLongest = 10;       // [s] of the mean that a motor's heat is

DeviceInfo limits_of(const SafetyOptions& o) {
  DeviceInfo out = o.device;
  if (out.is_live) out.max_force = std::min(out.max_force, o.max_force.value_or(kUsualForce));
  if (out.is_live && !(out.max_torque > 0)) out.max_torque = kUsualTorque;
  return out;
}

double coupling_of(const SafetyOptions& o) noexcept {
  if (!o.device.is_live || !o.device.gives_force) return 0;
  if (o.coupling) return *o.coupling;
  const double damping = o.damping > 0 ? o.damping : o.device.damping;
  const double delay = MeasuredDelay(o.h, o.delay.value_or(o.device.delay > 0 ? o.device.delay : -1)).estimate().delay;
  return coupling_stiffness(damping, o.device.max_stiffness, o.h, delay);
}

Vec3 shortened(const Vec3& v, double most) noexcept {
  const double size = v.norm();
  return size > most ? Vec3(most / size * v) : v;
}

/// Of a device whose own state shuts the gate; open: it does not.
GateReason reason_of(DeviceHealth health) noexcept {
  switch (health) {
    case DeviceHealth::ok:
      return GateReason::open;
    case DeviceHealth::stale:
      return GateReason::stale_pose;
    case DeviceHealth::gone:
      return GateReason::gone;
    case DeviceHealth::fault:
      return GateReason::fault;
    case DeviceHealth::uncalibrated:
      return GateReason::uncalibrated;
    case DeviceHealth::bad_pose:
      return GateReason::bad_pose;
    case DeviceHealth::unpowered:
      return GateReason::unpowered;
    case DeviceHealth::not_ready:
      return GateReason::not_ready;
    case DeviceHealth::in_use:
      return GateReason::in_use;
    case DeviceHealth::altered:
      return GateReason::altered;
    case DeviceHealth::no_echo:
      return GateReason::no_echo;
  }
  return GateReason::fault;
}

}  // namespace

const char* name_of(GateReason reason) noexcept {
  switch (reason) {
    case GateReason::open:
      return "open";
    case GateReason::stale_pose:
      return "the device's pose is older than 5 ms";
    case GateReason::gone:
      return "the device is gone";
    case GateReason::fault:
      return "the device reports a fault";
    case GateReason::uncalibrated:
      return "the device is not calibrated";
    case GateReason::button:
      return "the dead-man button is not held";
    case GateReason::no_model:
      return "there is no local model yet";
    case GateReason::stale_model:
      return "the body has not followed for long";
    case GateReason::inside:
      return "the tool is inside the body";
    case GateReason::on_the_way:
      return "the tool is on its way to the device";
    case GateReason::put_down:
      return "the tool was put down";
    case GateReason::bad_pose:
      return "the device's pose is no number, or far beyond any body";
    case GateReason::jumped:
      return "the device's pose leapt as no hand moves, and the tool follows it slowly";
    case GateReason::unpowered:
      return "the device has no power";
    case GateReason::not_ready:
      return "the device is not ready";
    case GateReason::in_use:
      return "another program uses the device";
    case GateReason::altered:
      return "the device's service changes places or forces on their way";
    case GateReason::no_echo:
      return "the device's service does not repeat the forces that it is sent";
    case GateReason::late_ticks:
      return "ticks come at less than half their rate";
  }
  return "";
}

GateReason main_reason(const SafetyCounts& counts) noexcept {
  GateReason out = GateReason::open;
  int most = 0;
  for (std::size_t i = 1; i < counts.by_reason.size(); ++i) {
    const auto reason = static_cast<GateReason>(i);
    if (reason == GateReason::put_down || reason == GateReason::on_the_way || counts.by_reason[i] <= most) continue;
    most = counts.by_reason[i];
    out = reason;
  }
  return out;
}

SafetyChain::SafetyChain(const SafetyOptions& options)
    : o_(options),
      limits_(limits_of(options)),
      coupling_({.stiffness = coupling_of(options), .adapts = false}),
      measured_(options.h, options.delay.value_or(options.device.delay > 0 ? options.device.delay : -1)),
      delay_(measured_.estimate()),
      followed_(options.scale),
      closing_(std::max(options.h, kZeroWithin - kOldest - 2 * options.h)),
      gate_(options.device.is_live ? 0 : 1) {
  if (!limits_.is_live) delay_ = {.delay = limits_.delay};
  if (limits_.yields)
    passivity_.emplace(PassivityOptions{.most_damping = o_.most_damping,
                                        .h = o_.h,
                                        .delay = delay_.delay,
                                        .max_force = limits_.max_force,
                                        .most_delay = limits_.is_live ? MeasuredDelay::kMost + 2 * o_.h : 0,
                                        .axes_apart = limits_.is_live,
                                        .encoder_step = limits_.is_live ? limits_.encoder_step : 0});
  if (limits_.is_live && limits_.yields && limits_.gives_torque && limits_.max_force > 0) {
    const double arm = limits_.max_torque / limits_.max_force;  // [m] at which the damper of the force is felt
    turning_.emplace(PassivityOptions{.most_damping = std::isfinite(arm) ? o_.most_damping * arm * arm : 0,
                                      .h = o_.h,
                                      .delay = delay_.delay,
                                      .max_force = limits_.max_torque,
                                      .most_delay = MeasuredDelay::kMost + 2 * o_.h});
  }
}

void SafetyChain::begin_at(const Vec3& tool) noexcept { followed_.begin_at(tool); }

Pose SafetyChain::tool(const Pose& device, double dt) noexcept {
  if (!limits_.is_live || !device.is_finite()) return device;
  const Pose tool = followed_.follow(device, dt);
  counts_.jumps = followed_.jumps();
  if (!(coupling_.stiffness() > 0)) return tool;
  is_coupled_ = true;
  return {o_.scale * coupling_.tool(tool.x / o_.scale, dt), tool.r};
}

/// Of a live device: from what it acknowledges, looked at four times a second.
void SafetyChain::follow_delay(const DeviceState& state) noexcept {
  if (state.delays != delays_) measured_.add(state.delay);
  delays_ = state.delays;
  if (counts_.ticks % std::max(1, static_cast<int>(0.25 / o_.h)) != 0) return;
  delay_ = measured_.estimate();
  if (passivity_) passivity_->set_delay(delay_.delay);
  if (turning_) turning_->set_delay(delay_.delay);
}

/// Why the gate has to be shut now; open: it need not.
GateReason SafetyChain::look(const LocalFrame& frame, const Pose& device, const DeviceState& state) noexcept {
  if (is_stopping_) return GateReason::put_down;
  if (const GateReason own = reason_of(state.health); own != GateReason::open) return own;
  if (!device.is_finite() || (frame.flags & kBadPose) != 0) return GateReason::bad_pose;
  if (!(state.age >= 0 && state.age <= kOldest)) return GateReason::stale_pose;
  if (o_.deadman != 0 && (state.buttons & o_.deadman) == 0) return GateReason::button;
  if ((frame.flags & (kStaleModel | kBodyFailed)) != 0) return GateReason::stale_model;
  if (slow_ticks_ >= 3) return GateReason::late_ticks;
  if (followed_.is_on_the_way()) return followed_.has_jumped() ? GateReason::jumped : GateReason::on_the_way;
  if (gate_ > 0) return GateReason::open;
  // To open it, more: there is something to touch, and the tool is not inside without being let out.
  if ((frame.flags & kNoModel) != 0) return GateReason::no_model;
  if ((frame.flags & (kNotFinite | kLostAnchor)) != 0) return GateReason::inside;
  return GateReason::open;
}

void SafetyChain::move_gate(double dt) noexcept {
  if (dt >= kZeroWithin) gate_ = 0;  // nobody ticked: the device has been let go by its own thread
  const double before = gate_;
  if (reason_ != GateReason::open && reason_ != GateReason::put_down) last_reason_ = reason_;
  gate_ += reason_ == GateReason::open ? std::min(dt, o_.h) / kOpening : -dt / closing_;
  gate_ = std::clamp(gate_, 0.0, 1.0);
  if (before == 1 && gate_ < 1) ++counts_.shut;
}

/// Not faster than max_slew; while the gate shuts, as fast as it has to.
Vec3 SafetyChain::slewed(const Vec3& force, double dt, LocalFrame& frame) noexcept {
  const bool shuts = reason_ != GateReason::open;
  const double slew = shuts ? std::max(o_.max_slew, limits_.max_force / closing_) : o_.max_slew;
  const double most = slew * (shuts ? dt : std::min(dt, o_.h));
  const Vec3 change = force - written_;
  if (!(change.norm() > most)) return force;
  frame.flags |= kSlewed;
  ++counts_.slewed;
  return written_ + shortened(change, most);
}

/// Gate, slew and limit of the torque: its slew is that of the force, as a share of the limit.
Vec3 SafetyChain::safe_torque(const Vec3& torque, double dt) noexcept {
  const double by_force = limits_.max_torque * o_.max_slew / limits_.max_force;
  const double most = std::max(by_force, limits_.max_torque / closing_) * dt;
  const Vec3 wanted = shortened(gate_ * torque, limits_.max_torque);
  torque_ += shortened(wanted - torque_, most);
  if (gate_ == 0) torque_.setZero();
  if (turning_) turning_->written(torque_);
  return torque_;
}

/// Force that the device may give now [N]: a motor warms with its square, and what it can bear for long is what it may
/// give once it is warm.
double SafetyChain::allowed(double dt) noexcept {
  const double lasting = limits_.continuous_force;
  if (!(lasting > 0) || lasting >= limits_.max_force) return limits_.max_force;
  heat_ += std::min(1.0, dt / kLongest) * (written_.squaredNorm() - heat_);
  const double warm = heat_ / (lasting * lasting);  // 1: no more than `lasting` from now on
  constexpr double kFree = 0.8;
  return lasting + (limits_.max_force - lasting) * std::clamp((1 - warm) / (1 - kFree), 0.0, 1.0);
}

/// Of a live device.
void SafetyChain::count(const DeviceState& state) noexcept {
  constexpr double kSmall = 0.02;  // [N] what is not felt need not be repeated
  counts_.gated += gate_ < 1;
  if (reason_ != GateReason::open) ++counts_.by_reason[static_cast<std::size_t>(reason_)];
  if (!state.echoed) return;
  counts_.most_echoed = state.most_echoed;
  counts_.unechoed += written_.norm() > kSmall && *state.echoed < 0.1 * written_.norm();
}

PortKnowledge SafetyChain::known(const LocalFrame& frame, const DeviceState& state) const noexcept {
  PortKnowledge out;
  if (!limits_.is_live) return out;  // of a simulated hand there is its encoder alone
  if (frame.f_n > 0) out.normal = frame.normal;
  if (!followed_.has_jumped()) out.velocity = state.v;
  return out;
}

Wrench SafetyChain::make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state, double dt) noexcept {
  ++counts_.ticks;
  const bool is_live = limits_.is_live;
  Vec3 force = o_.force_scale * frame.force, torque = o_.force_scale * frame.torque;
  // Finite.
  const bool is_finite = force.allFinite() && torque.allFinite();
  counts_.not_finite += !is_finite;
  if (device.x.allFinite()) at_ = device.x - followed_.jumped();
  const bool is_there =
      state.health == DeviceHealth::ok && state.age >= 0 && state.age <= kOldest && device.is_finite();
  counts_.stale += !is_there;
  if (!is_there) followed_.lose();
  if (!is_finite || !limits_.gives_force) force.setZero();
  if (!is_finite || (is_live && !limits_.gives_torque)) torque.setZero();
  if (!is_live && !is_there) {  // it is not where its pose says: what is felt there is not its force
    force.setZero();
    torque.setZero();
  }
  if (is_live) follow_delay(state);
  if (is_coupled_) force = coupling_.force(force, frame.f_n > 0 ? frame.normal : Vec3(Vec3::Zero()));
  is_coupled_ = false;
  bool limited = false;
  if (passivity_)
    force = passivity_->tick(at_ / o_.scale, force, is_live ? dt : o_.h, known(frame, state));
  else
    force = safe_force(force, limits_, limited);
  if (passivity_) limited = passivity_->limited();
  if (turning_) torque = turning_->tick(device.is_finite() ? turned_.add(device.r) : turned_.sum(), torque, dt);
  if (is_live) {
    slow_ticks_ = dt > 2 * o_.h ? slow_ticks_ + 1 : 0;
    reason_ = look(frame, device, state);
    move_gate(dt);
    if (dt >= kZeroWithin) written_.setZero();
    force = slewed(gate_ * force, dt, frame);
    bool warm = false;
    DeviceInfo now = {};
    now.max_force = allowed(dt);
    force = safe_force(force, now, warm);
    limited = limited || warm;
    torque = safe_torque(torque, dt);
    if (passivity_) passivity_->written(force);
    if (gate_ < 1) frame.flags |= kGated;
    if (!is_there) frame.flags |= kStalePose;
    count(state);
  }
  if (!is_live && o_.fades_when_stale) {
    reason_ = (frame.flags & (kStaleModel | kBodyFailed)) != 0 ? GateReason::stale_model : GateReason::open;
    move_gate(o_.h);
    force *= gate_;
    torque *= gate_;
    if (gate_ < 1) frame.flags |= kGated;
    counts_.gated += gate_ < 1;
  }
  // Booked.
  counts_.limited += limited;
  counts_.most_force = std::max(counts_.most_force, force.norm());
  if (counts_.ticks > 1 && dt > 0) counts_.most_slew = std::max(counts_.most_slew, (force - written_).norm() / dt);
  written_ = force;
  frame.force = force / o_.force_scale;
  frame.torque = torque / o_.force_scale;
  return {force, torque};
}

}  // namespace kt
