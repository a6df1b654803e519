// Plays a recorded tool path: at each tick the place of its time, whatever the force.
#include <algorithm>
#include <cmath>

#include "haptics/device/recording.hpp"

namespace kt {
namespace {

class Recorded final : public HapticDevice {
 public:
  explicit Recorded(const DeviceOptions& options)
      : path_(options.path), same_(kSame * options.h), limits_(options.limits), speed_(tick_speed(options.h)) {}
  Vec3 position(double t) noexcept override {
    const auto after = std::ranges::upper_bound(path_, t - same_, {}, &TimedPoint::t);
    // A row of this very tick is taken bit for bit: interpolation would change its last bits.
    if (after != path_.end() && after->t <= t + same_) return after->x;
    return interpolate_path(path_, t);
  }
  void write(const Vec3&, double) noexcept override {}
  DeviceLimits limits() const override { return limits_; }
  double max_speed() const override { return speed_; }

 private:
  static constexpr double kSame = 1e-6;  // of a tick

  /// Largest from tick to tick, around every row: between ticks nobody looks, between rows it does not change.
  double tick_speed(double h) {
    double most = 0;
    for (const TimedPoint& row : path_) {
      const double tick = std::floor(row.t / h);
      for (const double from : {tick - 1, tick, tick + 1})
        most = std::max(most, (position((from + 1) * h) - position(from * h)).norm() / h);
    }
    return most;
  }

  std::vector<TimedPoint> path_;
  double same_;
  DeviceLimits limits_;
  double speed_;
};

}  // namespace

std::unique_ptr<HapticDevice> make_recorded_device(const DeviceOptions& options) {
  if (!options.path.empty()) return std::make_unique<Recorded>(options);
  DeviceOptions read = options;
  read.path = read_recording(options.recording, options.h).path;
  return std::make_unique<Recorded>(read);
}

}  // namespace kt
