// Plays a recorded tool path: at each tick the place of its time, whatever the force.
#include <algorithm>
#include <cmath>
#include <optional>

#include "haptics/device/recording.hpp"

namespace kt {
namespace {

class Recorded final : public HapticDevice {
 public:
  explicit Recorded(const DeviceOptions& options)
      : poses_(options.poses), same_(kSame * options.h), info_(options.info) {
    if (poses_.empty()) {
      turn_ = options.turn;
      for (const TimedPoint& p : options.path) poses_.push_back({p.t, {p.x, Quaternion::Identity()}});
    }
    speed_ = tick_speed(options.h);
  }
  Pose pose(double t) noexcept override {
    Pose out = recorded(t);
    if (turn_) out.r = turn_->at(t);
    return out;
  }
  void write(const Wrench&, double) noexcept override {}
  DeviceInfo info() const override { return info_; }
  double max_speed() const override { return speed_; }

 private:
  static constexpr double kSame = 1e-6;  // of a tick

  Pose recorded(double t) const noexcept {
    const auto after = std::ranges::upper_bound(poses_, t - same_, {}, &TimedPose::t);
    // A row of this very tick is taken bit for bit: interpolation would change its last bits.
    if (after != poses_.end() && after->t <= t + same_) return after->pose;
    return interpolate_poses(poses_, t);
  }

  /// Largest from tick to tick, around every row: between ticks nobody looks, between rows it does not change.
  double tick_speed(double h) {
    double most = 0;
    for (const TimedPose& row : poses_) {
      const double tick = std::floor(row.t / h);
      for (const double from : {tick - 1, tick, tick + 1})
        most = std::max(most, (recorded((from + 1) * h).x - recorded(from * h).x).norm() / h);
    }
    return most;
  }

  std::vector<TimedPose> poses_;
  std::optional<ToolTurn> turn_;  // of a recording without orientations
  double same_;
  DeviceInfo info_;
  double speed_ = 0;
};

}  // namespace

std::unique_ptr<HapticDevice> make_recorded_device(const DeviceOptions& options) {
  if (!options.path.empty() || !options.poses.empty()) return std::make_unique<Recorded>(options);
  DeviceOptions read = options;
  Recording recording = read_recording(options.recording, options.h);
  read.path = std::move(recording.path);
  read.poses = std::move(recording.poses);
  return std::make_unique<Recorded>(read);
}

}  // namespace kt
