#pragma once
// A device at its tool: poses from it, forces to it through the safety chain.
#include <cmath>

#include "haptics/guard/safety_chain.hpp"

namespace kt {

class GuardedDevice {
 public:
  GuardedDevice(std::unique_ptr<HapticDevice> device, SafetyOptions options)
      : device_(std::move(device)), chain_(with_info(std::move(options), *device_)) {}

  /// The tool is there when the first tick comes.
  void begin_at(const Vec3& tool) noexcept { chain_.begin_at(tool); }

  /// Where the tool is to go at time t [s], `dt` after the last call.
  Pose pose(double t, double dt) noexcept {
    at_ = device_->pose(t);
    state_ = device_->state();
    return chain_.tool(at_, dt);
  }

  /// Writes what the device may be given of the frame's force, and puts that in the frame, with its normal and
  /// tangential parts. Returns the model's force.
  /// @param dt  since the last call [s]
  Vec3 give(LocalFrame& frame, double h, double dt) noexcept {
    const Vec3 wanted = frame.force;
    device_->write(chain_.make_safe(frame, at_, state_, dt), h);
    split_given(wanted, frame);
    const bool is_gone = state_.health == DeviceHealth::gone || state_.health == DeviceHealth::fault ||
                         state_.health == DeviceHealth::unpowered;
    gone_for_ = is_gone ? gone_for_ + dt : 0;
    return wanted;
  }

  /// At the end of a run, tick after tick for SafetyChain::kZeroWithin: the last force fades.
  void put_down(LocalFrame frame, double h) noexcept {
    chain_.shut();
    device_->write(chain_.make_safe(frame, device_->pose(0), device_->state(), h), h);
  }

  const HapticDevice& device() const noexcept { return *device_; }
  const DeviceState& state() const noexcept { return state_; }
  const SafetyChain& chain() const noexcept { return chain_; }
  double gone_for() const noexcept { return gone_for_; }  ///< [s]

 private:
  /// What was held back is so in both parts; what was added is split along the contact's normal.
  static void split_given(const Vec3& wanted, LocalFrame& frame) noexcept {
    if (frame.force == wanted || frame.mode == ContactMode::free) return;
    const double size_sq = wanted.squaredNorm(), share = size_sq > 0 ? frame.force.dot(wanted) / size_sq : 0;
    const Vec3 added = frame.force - share * wanted;
    const double normal = added.dot(frame.normal);
    frame.f_n = share * frame.f_n + normal;
    frame.f_t = std::abs(share) * frame.f_t + (added - normal * frame.normal).norm();
  }
  static SafetyOptions with_info(SafetyOptions options, const HapticDevice& device) {
    options.device = device.info();
    return options;
  }
  std::unique_ptr<HapticDevice> device_;
  SafetyChain chain_;
  Pose at_;
  DeviceState state_;
  double gone_for_ = 0;
};

}  // namespace kt
