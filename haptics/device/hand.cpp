// A simulated hand holding a device: m x'' = k (target - x) + d (target' - x') + force, solved exactly between writes;
// the encoder reads multiples of its step; the force is what the device can give, and reaches the motors after a delay.
#include <cmath>

#include "haptics/device/hand_motion.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/device/moved_target.hpp"

namespace kt {
namespace {

class Hand final : public HapticDevice {
 public:
  explicit Hand(const DeviceOptions& o) : o_(o), x_(o.path.front().x), speed_(path_speed(o.path)) {
    const double ticks = o.hand_delay / o.h;
    const double whole = std::floor(ticks * (1 + 1e-12));
    late_ = std::max(0.0, ticks - whole) * o.h;
    // The force of the last write and those that are still on their way, newest first.
    forces_.assign(static_cast<std::size_t>(whole) + 2, Vec3::Zero());
    set_step(o.h);
  }

  Pose pose(double t) noexcept override {
    const Quaternion turn = o_.turn.at(t);
    if (o_.encoder_step <= 0) return {x_, turn};
    return {(x_ / o_.encoder_step).array().round().matrix() * o_.encoder_step, turn};
  }

  void write(const Wrench& wrench, double h) noexcept override {
    if (h != h_) set_step(h);
    const Vec3 target_t0 = o_.target ? o_.target->now() : interpolate_path(o_.path, t_);
    const Vec3 target_t1 = o_.target ? o_.target->step(h) : interpolate_path(o_.path, t_ + h);
    const Vec3 target_velocity = (target_t1 - target_t0) / h;
    std::move_backward(forces_.begin(), forces_.end() - 1, forces_.end());
    forces_.front() = wrench.force;
    // Relative to the target, which moves evenly, the hand is an oscillator.
    Vec3 y = x_ - target_t0, v = v_ - target_velocity;
    if (late_ > 0) before_.step(y, v, forces_.back());
    after_.step(y, v, forces_[forces_.size() - 2]);
    x_ = target_t1 + y;
    v_ = v + target_velocity;
    t_ += h;
  }
  DeviceInfo info() const override { return {o_.max_force, o_.hand_delay, true}; }
  // The hand can overshoot its target's speed when it slips off something: twice is generous.
  double max_speed() const override { return o_.target ? std::numeric_limits<double>::infinity() : 2 * speed_ + 0.05; }

 private:
  void set_step(double h) noexcept {
    h_ = h;
    late_ = std::min(late_, h);
    before_ = {o_.hand_mass, o_.hand_damping, o_.hand_stiffness, late_};
    after_ = {o_.hand_mass, o_.hand_damping, o_.hand_stiffness, h - late_};
  }

  DeviceOptions o_;
  Vec3 x_, v_ = Vec3::Zero();
  double t_ = 0, speed_;
  double h_ = 0, late_ = 0;  // the step; how far into it an older force still acts [s]
  std::vector<Vec3> forces_;
  HandMotion before_, after_;
};

}  // namespace

std::unique_ptr<HapticDevice> make_hand_device(const DeviceOptions& options) {
  if (options.path.empty()) throw InputError("tool.path.hand.target: the path has no points");
  if (!(options.hand_mass > 0)) throw InputError(text("tool.path.hand.mass = ", options.hand_mass, " kg: must be > 0"));
  if (!(options.hand_stiffness > 0))
    throw InputError(text("tool.path.hand.stiffness = ", options.hand_stiffness, " N/m: must be > 0"));
  if (!(options.hand_delay >= 0 && options.hand_delay <= 1))
    throw InputError(text("tool.path.hand.delay_ms = ", 1e3 * options.hand_delay, ": must be in [0, 1000]"));
  return std::make_unique<Hand>(options);
}

}  // namespace kt
