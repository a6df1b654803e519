// A simulated hand holding a device: m x'' = k (target - x) + d (target' - x') + force, stepped semi-implicitly with
// the haptic step; the encoder reads multiples of its step; the force is what the device can give.
#include <cmath>

#include "haptics/device/haptic_device.hpp"

namespace kt {
namespace {

class Hand final : public HapticDevice {
 public:
  explicit Hand(const DeviceOptions& o) : o_(o), x_(o.path.front().x), speed_(path_speed(o.path)) {}

  Vec3 position(double) noexcept override {
    if (o_.encoder_step <= 0) return x_;
    return (x_ / o_.encoder_step).array().round().matrix() * o_.encoder_step;
  }

  void write(const Vec3& force, double h) noexcept override {
    const Vec3 target = interpolate_path(o_.path, t_ + h);
    const Vec3 target_velocity = (target - interpolate_path(o_.path, t_)) / h;
    // Spring and damper at the end of the step: stable for any hand.
    const double system = o_.hand_mass + h * o_.hand_damping + h * h * o_.hand_stiffness;
    v_ = (o_.hand_mass * v_ + h * (force + o_.hand_stiffness * (target - x_) + o_.hand_damping * target_velocity)) /
         system;
    x_ += h * v_;
    t_ += h;
  }
  DeviceLimits limits() const override { return {o_.max_force}; }
  // The hand can overshoot its target's speed when it slips off something: twice is generous.
  double max_speed() const override { return 2 * speed_ + 0.05; }

 private:
  DeviceOptions o_;
  Vec3 x_, v_ = Vec3::Zero();
  double t_ = 0, speed_;
};

}  // namespace

std::unique_ptr<HapticDevice> make_hand_device(const DeviceOptions& options) {
  if (options.path.empty()) throw InputError("tool.path.hand.target: the path has no points");
  if (!(options.hand_mass > 0)) throw InputError(text("tool.path.hand.mass = ", options.hand_mass, " kg: must be > 0"));
  return std::make_unique<Hand>(options);
}

}  // namespace kt
