#include "haptics/driver/live_device.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <thread>

namespace kt {

std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

namespace {

Vec3 vector(const double (&v)[3]) noexcept { return {v[0], v[1], v[2]}; }

class LiveDevice final : public HapticDevice {
 public:
  LiveDevice(const DeviceOptions& o, OpenDriver open)
      : slots_(o.slots ? o.slots : std::make_shared<DeviceSlots>()), driver_(open(o.live, *slots_)) {
    let_go_on_fatal_signals();
    info_ = driver_->info();
    info_.is_live = true;
    info_.yields = info_.gives_force;
    frame_.r = device_axes(o.live.axes);
    is_laid_along_pen_ = info_.senses_turn && o.turn.turn.isZero(0) && !info_.pen_turn.isZero(0);
    mount_ = rotation(is_laid_along_pen_ ? info_.pen_turn : o.turn.turn);
    frame_.scale = o.live.scale;
    first_reading(o.live.name);
    frame_.origin = o.live.origin.value_or(frame_.origin_for(vector(reading_.x), o.over));
    take();
  }

  Pose pose(double) noexcept override {
    take();
    return pose_;
  }
  DeviceState state() const noexcept override { return state_; }

  void write(const Wrench& wrench, double) noexcept override {
    DeviceOrder order;
    const Vec3 force = frame_.r.transpose() * wrench.force, torque = frame_.r.transpose() * wrench.torque;
    for (int i = 0; i < 3; ++i) {
      order.force[i] = force[i];
      order.torque[i] = torque[i];
    }
    if (!order.is_finite()) order = {};
    order.at_ns = monotonic_ns();
    order.count = ++orders_;
    slots_->order.put(order);
  }
  DeviceInfo info() const override { return info_; }
  std::vector<std::string> notes() const override {
    std::vector<std::string> out = driver_->notes();
    if (is_laid_along_pen_)
      out.push_back("the tool lies along the pen, its -z towards the pen's tip; tool.turn turns it otherwise");
    return out;
  }
  Vec3 origin() const override { return frame_.origin; }
  double max_speed() const override { return std::numeric_limits<double>::infinity(); }

 private:
  void first_reading(const std::string& name) {
    for (int i = 0; i < 200; ++i) {
      if (slots_->reading.read(reading_) && reading_.count > 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const DeviceHealth health = slots_->health.load(std::memory_order_relaxed);
    throw InputError(text("tool.path.device: ", name, " \"", info_.name,
                          "\" is open, but has sent no pose for 2 s; its state: ", name_of(health),
                          health == DeviceHealth::ok ? "; is it switched on, and calibrated?" : ""));
  }

  void take() noexcept {
    slots_->reading.read(reading_);
    const double age = 1e-9 * static_cast<double>(monotonic_ns() - reading_.at_ns);
    state_.age = std::max(0.0, age);
    state_.health = slots_->health.load(std::memory_order_relaxed);
    if (state_.health == DeviceHealth::ok && age > kOldestPose) state_.health = DeviceHealth::stale;
    state_.buttons = static_cast<unsigned>(reading_.buttons);
    state_.delay = reading_.delay;
    state_.delays = static_cast<unsigned>(reading_.delays);
    state_.most_echoed = reading_.most_echoed;
    state_.echoed.reset();
    if (std::isfinite(reading_.echoed)) state_.echoed = reading_.echoed;
    const Vec3 v = vector(reading_.v);
    state_.v.reset();
    if (v.allFinite()) state_.v = frame_.r * v;
    if (!reading_.is_finite()) {  // of a driver that lets it pass: the tool stays where it was
      if (state_.health == DeviceHealth::ok) state_.health = DeviceHealth::bad_pose;
      return;
    }
    const Quaternion turn(reading_.turn[0], reading_.turn[1], reading_.turn[2], reading_.turn[3]);
    pose_ = {frame_.to_world(vector(reading_.x)), info_.senses_turn ? frame_.to_world(turn) * mount_ : mount_};
  }

  std::shared_ptr<DeviceSlots> slots_;
  std::unique_ptr<DeviceDriver> driver_;  // after the slots: its thread ends first
  DeviceInfo info_;
  DeviceFrame frame_;
  Quaternion mount_ = Quaternion::Identity();  // of the tool on the stylus; without a sensed turn, in the world
  DeviceReading reading_;
  DeviceState state_;
  Pose pose_;
  std::uint64_t orders_ = 0;
  bool is_laid_along_pen_ = false;
};

}  // namespace

std::unique_ptr<HapticDevice> make_live_device(const DeviceOptions& options, OpenDriver open) {
  return std::make_unique<LiveDevice>(options, open);
}

}  // namespace kt
