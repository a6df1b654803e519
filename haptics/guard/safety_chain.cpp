#include "haptics/guard/safety_chain.hpp"

#include <algorithm>
#include <cmath>

#include "haptics/guard/followed_pose.hpp"
#include "haptics/safety/device_coupling.hpp"
#include "haptics/safety/measured_delay.hpp"
#include "haptics/safety/passivity.hpp"

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

static_assert(SafetyChain::kFollows == FollowedPose::kFollows);

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

struct SafetyChain::Parts {
  explicit Parts(const SafetyOptions& options);
  Pose tool(const Pose& device, double dt) noexcept;
  Wrench make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state, double dt) noexcept;
  PortKnowledge known(const LocalFrame& frame, const DeviceState& state) const noexcept;
  GateReason look(const LocalFrame& frame, const Pose& device, const DeviceState& state) noexcept;
  void count(const DeviceState& state) noexcept;
  void follow_delay(const DeviceState& state) noexcept;
  void move_gate(double dt) noexcept;
  Vec3 slewed(const Vec3& force, double dt, LocalFrame& frame) noexcept;
  Vec3 safe_torque(const Vec3& torque, double dt) noexcept;
  double allowed(double dt) noexcept;

  SafetyOptions o;
  DeviceInfo limits;                                   // the device's, with the force that the scene allows
  std::optional<PassivityControl> passivity, turning;  // of a device that moves with the force; of its torque
  TurnSum turned;                                      // of the device [rad]
  DeviceCoupling coupling;
  MeasuredDelay measured;
  DelayEstimate delay;
  unsigned delays = 0;  // that the device has told
  Vec3 written = Vec3::Zero(), written_torque = Vec3::Zero();
  FollowedPose followed;  // the tool before the coupling's stretch
  GateReason last_reason = GateReason::no_model;
  Vec3 at = Vec3::Zero();  // the device's place, the last that was finite, without its leaps
  double closing;          // [s]
  double gate = 0, heat = 0;
  int slow_ticks = 0;
  bool is_stopping = false, is_coupled = false;  // the latter: tool() was called for this tick
  GateReason reason = GateReason::no_model;
  SafetyCounts counts;
};

SafetyChain::Parts::Parts(const SafetyOptions& options)
    : o(options),
      limits(limits_of(options)),
      coupling({.stiffness = coupling_of(options), .adapts = false}),
      measured(options.h, options.delay.value_or(options.device.delay > 0 ? options.device.delay : -1)),
      delay(measured.estimate()),
      followed(options.scale),
      closing(std::max(options.h, kZeroWithin - kOldest - 2 * options.h)),
      gate(options.device.is_live ? 0 : 1) {
  if (!limits.is_live) delay = {.delay = limits.delay};
  if (limits.yields)
    passivity.emplace(PassivityOptions{.most_damping = o.most_damping,
                                       .h = o.h,
                                       .delay = delay.delay,
                                       .max_force = limits.max_force,
                                       .most_delay = limits.is_live ? MeasuredDelay::kMost + 2 * o.h : 0,
                                       .axes_apart = limits.is_live,
                                       .encoder_step = limits.is_live ? limits.encoder_step : 0});
  if (limits.is_live && limits.yields && limits.gives_torque && limits.max_force > 0) {
    const double arm = limits.max_torque / limits.max_force;  // [m] at which the damper of the force is felt
    turning.emplace(PassivityOptions{.most_damping = std::isfinite(arm) ? o.most_damping * arm * arm : 0,
                                     .h = o.h,
                                     .delay = delay.delay,
                                     .max_force = limits.max_torque,
                                     .most_delay = MeasuredDelay::kMost + 2 * o.h});
  }
}

Pose SafetyChain::Parts::tool(const Pose& device, double dt) noexcept {
  if (!limits.is_live || !device.is_finite()) return device;
  const Pose tool = followed.follow(device, dt);
  counts.jumps = followed.jumps();
  if (!(coupling.stiffness() > 0)) return tool;
  is_coupled = true;
  return {o.scale * coupling.tool(tool.x / o.scale, dt), tool.r};
}

/// Of a live device: from what it acknowledges, looked at four times a second.
void SafetyChain::Parts::follow_delay(const DeviceState& state) noexcept {
  if (state.delays != delays) measured.add(state.delay);
  delays = state.delays;
  if (counts.ticks % std::max(1, static_cast<int>(0.25 / o.h)) != 0) return;
  delay = measured.estimate();
  if (passivity) passivity->set_delay(delay.delay);
  if (turning) turning->set_delay(delay.delay);
}

/// Why the gate has to be shut now; open: it need not.
GateReason SafetyChain::Parts::look(const LocalFrame& frame, const Pose& device, const DeviceState& state) noexcept {
  if (is_stopping) return GateReason::put_down;
  if (const GateReason own = reason_of(state.health); own != GateReason::open) return own;
  if (!device.is_finite() || (frame.flags & kBadPose) != 0) return GateReason::bad_pose;
  if (!(state.age >= 0 && state.age <= kOldest)) return GateReason::stale_pose;
  if (o.deadman != 0 && (state.buttons & o.deadman) == 0) return GateReason::button;
  if ((frame.flags & (kStaleModel | kBodyFailed)) != 0) return GateReason::stale_model;
  if (slow_ticks >= 3) return GateReason::late_ticks;
  if (followed.is_on_the_way()) return followed.has_jumped() ? GateReason::jumped : GateReason::on_the_way;
  if (gate > 0) return GateReason::open;
  // To open it, more: there is something to touch, and the tool is not inside without being let out.
  if ((frame.flags & kNoModel) != 0) return GateReason::no_model;
  if ((frame.flags & (kNotFinite | kLostAnchor)) != 0) return GateReason::inside;
  return GateReason::open;
}

void SafetyChain::Parts::move_gate(double dt) noexcept {
  if (dt >= kZeroWithin) gate = 0;  // nobody ticked: the device has been let go by its own thread
  const double before = gate;
  if (reason != GateReason::open && reason != GateReason::put_down) last_reason = reason;
  gate += reason == GateReason::open ? std::min(dt, o.h) / kOpening : -dt / closing;
  gate = std::clamp(gate, 0.0, 1.0);
  if (before == 1 && gate < 1) ++counts.shut;
}

/// Not faster than max_slew; while the gate shuts, as fast as it has to.
Vec3 SafetyChain::Parts::slewed(const Vec3& force, double dt, LocalFrame& frame) noexcept {
  const bool shuts = reason != GateReason::open;
  const double slew = shuts ? std::max(o.max_slew, limits.max_force / closing) : o.max_slew;
  const double most = slew * (shuts ? dt : std::min(dt, o.h));
  const Vec3 change = force - written;
  if (!(change.norm() > most)) return force;
  frame.flags |= kSlewed;
  ++counts.slewed;
  return written + shortened(change, most);
}

/// Gate, slew and limit of the torque: its slew is that of the force, as a share of the limit.
Vec3 SafetyChain::Parts::safe_torque(const Vec3& torque, double dt) noexcept {
  const double by_force = limits.max_torque * o.max_slew / limits.max_force;
  const double most = std::max(by_force, limits.max_torque / closing) * dt;
  const Vec3 wanted = shortened(gate * torque, limits.max_torque);
  written_torque += shortened(wanted - written_torque, most);
  if (gate == 0) written_torque.setZero();
  if (turning) turning->written(written_torque);
  return written_torque;
}

/// Force that the device may give now [N]: a motor warms with its square, and what it can bear for long is what it may
/// give once it is warm.
double SafetyChain::Parts::allowed(double dt) noexcept {
  const double lasting = limits.continuous_force;
  if (!(lasting > 0) || lasting >= limits.max_force) return limits.max_force;
  heat += std::min(1.0, dt / kLongest) * (written.squaredNorm() - heat);
  const double warm = heat / (lasting * lasting);  // 1: no more than `lasting` from now on
  constexpr double kFree = 0.8;
  return lasting + (limits.max_force - lasting) * std::clamp((1 - warm) / (1 - kFree), 0.0, 1.0);
}

/// Of a live device.
void SafetyChain::Parts::count(const DeviceState& state) noexcept {
  constexpr double kSmall = 0.02;  // [N] what is not felt need not be repeated
  counts.gated += gate < 1;
  if (reason != GateReason::open) ++counts.by_reason[static_cast<std::size_t>(reason)];
  if (!state.echoed) return;
  counts.most_echoed = state.most_echoed;
  counts.unechoed += written.norm() > kSmall && *state.echoed < 0.1 * written.norm();
}

PortKnowledge SafetyChain::Parts::known(const LocalFrame& frame, const DeviceState& state) const noexcept {
  PortKnowledge out;
  if (!limits.is_live) return out;  // of a simulated hand there is its encoder alone
  if (frame.f_n > 0) out.normal = frame.normal;
  if (!followed.has_jumped()) out.velocity = state.v;
  return out;
}

Wrench SafetyChain::Parts::make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state,
                                     double dt) noexcept {
  ++counts.ticks;
  const bool is_live = limits.is_live;
  Vec3 force = o.force_scale * frame.force, torque = o.force_scale * frame.torque;
  // Finite.
  const bool is_finite = force.allFinite() && torque.allFinite();
  counts.not_finite += !is_finite;
  if (device.x.allFinite()) at = device.x - followed.jumped();
  const bool is_there =
      state.health == DeviceHealth::ok && state.age >= 0 && state.age <= kOldest && device.is_finite();
  counts.stale += !is_there;
  if (!is_there) followed.lose();
  if (!is_finite || !limits.gives_force) force.setZero();
  if (!is_finite || (is_live && !limits.gives_torque)) torque.setZero();
  if (!is_live && !is_there) {  // it is not where its pose says: what is felt there is not its force
    force.setZero();
    torque.setZero();
  }
  if (is_live) follow_delay(state);
  if (is_coupled) force = coupling.force(force, frame.f_n > 0 ? frame.normal : Vec3(Vec3::Zero()));
  is_coupled = false;
  bool limited = false;
  if (passivity)
    force = passivity->tick(at / o.scale, force, is_live ? dt : o.h, known(frame, state));
  else
    force = safe_force(force, limits, limited);
  if (passivity) limited = passivity->limited();
  if (turning) torque = turning->tick(device.is_finite() ? turned.add(device.r) : turned.sum(), torque, dt);
  if (is_live) {
    slow_ticks = dt > 2 * o.h ? slow_ticks + 1 : 0;
    reason = look(frame, device, state);
    move_gate(dt);
    if (dt >= kZeroWithin) written.setZero();
    force = slewed(gate * force, dt, frame);
    bool warm = false;
    DeviceInfo now = {};
    now.max_force = allowed(dt);
    force = safe_force(force, now, warm);
    limited = limited || warm;
    torque = safe_torque(torque, dt);
    if (passivity) passivity->written(force);
    if (gate < 1) frame.flags |= kGated;
    if (!is_there) frame.flags |= kStalePose;
    count(state);
  }
  if (!is_live && o.fades_when_stale) {
    reason = (frame.flags & (kStaleModel | kBodyFailed)) != 0 ? GateReason::stale_model : GateReason::open;
    move_gate(o.h);
    force *= gate;
    torque *= gate;
    if (gate < 1) frame.flags |= kGated;
    counts.gated += gate < 1;
  }
  // Booked.
  counts.limited += limited;
  counts.most_force = std::max(counts.most_force, force.norm());
  if (counts.ticks > 1 && dt > 0) counts.most_slew = std::max(counts.most_slew, (force - written).norm() / dt);
  written = force;
  frame.force = force / o.force_scale;
  frame.torque = torque / o.force_scale;
  return {force, torque};
}

SafetyChain::SafetyChain(const SafetyOptions& options) : parts_(std::make_unique<Parts>(options)) {}
SafetyChain::~SafetyChain() = default;
SafetyChain::SafetyChain(SafetyChain&&) noexcept = default;
SafetyChain& SafetyChain::operator=(SafetyChain&&) noexcept = default;

void SafetyChain::begin_at(const Vec3& tool) noexcept { parts_->followed.begin_at(tool); }
Pose SafetyChain::tool(const Pose& device, double dt) noexcept { return parts_->tool(device, dt); }
Wrench SafetyChain::make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state, double dt) noexcept {
  return parts_->make_safe(frame, device, state, dt);
}
void SafetyChain::shut() noexcept { parts_->is_stopping = true; }

double SafetyChain::gate() const noexcept { return parts_->gate; }
GateReason SafetyChain::reason() const noexcept { return parts_->reason; }
GateReason SafetyChain::last_reason() const noexcept { return parts_->last_reason; }
const SafetyCounts& SafetyChain::counts() const noexcept { return parts_->counts; }
const PassivityControl* SafetyChain::passivity() const noexcept {
  return parts_->passivity ? &*parts_->passivity : nullptr;
}
const PassivityControl* SafetyChain::turning() const noexcept { return parts_->turning ? &*parts_->turning : nullptr; }
double SafetyChain::coupling() const noexcept { return parts_->coupling.stiffness(); }
const DelayEstimate& SafetyChain::delay() const noexcept { return parts_->delay; }
double SafetyChain::max_force() const noexcept { return parts_->limits.max_force; }

}  // namespace kt
