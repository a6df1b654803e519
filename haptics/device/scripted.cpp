// A tool that follows its path whatever the force.
#include <cmath>

#include "haptics/device/haptic_device.hpp"

namespace kt {
namespace {

class Scripted final : public HapticDevice {
 public:
  explicit Scripted(const DeviceOptions& options)
      : path_(options.path), turn_(options.turn), speed_(path_speed(path_)) {}
  Pose pose(double t) noexcept override { return {interpolate_path(path_, t), turn_.at(t)}; }
  void write(const Wrench&, double) noexcept override {}
  DeviceInfo info() const override { return {}; }
  double max_speed() const override { return speed_; }

 private:
  std::vector<TimedPoint> path_;
  ToolTurn turn_;
  double speed_;
};

}  // namespace

std::unique_ptr<HapticDevice> make_scripted_device(const DeviceOptions& options) {
  if (options.path.empty()) throw InputError("tool.path: the path has no points");
  for (std::size_t i = 0; i < options.path.size(); ++i) {
    if (!options.path[i].x.allFinite() || !std::isfinite(options.path[i].t))
      throw InputError(text("tool.path: point ", i, " is not finite"));
    if (i > 0 && !(options.path[i].t > options.path[i - 1].t))
      throw InputError(text("tool.path: time ", options.path[i].t, " s of point ", i, " does not follow ",
                            options.path[i - 1].t, " s"));
  }
  return std::make_unique<Scripted>(options);
}

}  // namespace kt
