// Plays the tool path of a recording: one position a tick, bit for bit. The file holds "t,x,y,z" lines with 17 digits.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "haptics/device/haptic_device.hpp"
#include "io/text_reader.hpp"

namespace kt {
namespace {

class Recorded final : public HapticDevice {
 public:
  explicit Recorded(std::vector<TimedPoint> path, double h)
      : path_(std::move(path)), h_(h), speed_(path_speed(path_)) {}
  Vec3 position(double t) noexcept override {
    // By tick and not by interpolation, which would change the last bits.
    const double tick = (t - path_.front().t) / h_;
    const auto last = static_cast<double>(path_.size() - 1);
    return path_[static_cast<std::size_t>(std::clamp(tick + 0.5, 0.0, last))].x;
  }
  void write(const Vec3&, double) noexcept override {}
  DeviceLimits limits() const override { return {}; }
  double max_speed() const override { return speed_; }

 private:
  std::vector<TimedPoint> path_;
  double h_, speed_;
};

constexpr double kFarthest = 1e6;  // [m] as a scene's waypoints: beyond, squares of distances end

std::vector<TimedPoint> load_path(const std::string& file) {
  std::istringstream in(read_whole_file(file));
  std::vector<TimedPoint> path;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.rfind("t,", 0) == 0) continue;  // column names
    double value[4];
    const char *next = line.data(), *end = line.data() + line.size();
    for (int i = 0; i < 4; ++i) {
      const auto [stop, error] = std::from_chars(next, end, value[i]);
      const bool separated = i == 3 || (stop < end && *stop == ',');
      if (error == std::errc{} && i > 0 && std::abs(value[i]) > kFarthest)
        throw InputError(
            text(file, ":", number, ": coordinate ", value[i], " m, must be within ", kFarthest, " m of the origin"));
      if (error != std::errc{} || !separated || !std::isfinite(value[i]))
        throw InputError(text(file, ":", number, ": expected four finite numbers \"t,x,y,z\", found \"", line, "\""));
      next = stop + 1;
    }
    if (!path.empty() && !(value[0] > path.back().t))
      throw InputError(text(file, ":", number, ": time ", value[0], " s does not follow ", path.back().t, " s"));
    path.push_back({value[0], {value[1], value[2], value[3]}});
  }
  if (path.empty()) throw InputError(text(file, ": the recording is empty"));
  return path;
}

}  // namespace

std::unique_ptr<HapticDevice> make_recorded_device(const DeviceOptions& options) {
  return std::make_unique<Recorded>(load_path(options.recording), options.h);
}

}  // namespace kt
