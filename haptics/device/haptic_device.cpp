#include "haptics/device/haptic_device.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

#define DEVICE(name, available, option, what) std::unique_ptr<HapticDevice> make_##name##_device(const DeviceOptions&);
#include "haptics/device/device.def"
#undef DEVICE

std::vector<BackendInfo> device_backends() {
  return {
#define DEVICE(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/device/device.def"
#undef DEVICE
  };
}

std::unique_ptr<HapticDevice> make_device(const std::string& name, const DeviceOptions& options) {
#define DEVICE(known, available, option, what) \
  if (name == #known) return make_##known##_device(options);
#include "haptics/device/device.def"
#undef DEVICE
  require_backend("device", name, device_backends());
  return nullptr;
}

Vec3 safe_force(const Vec3& force, const DeviceLimits& limits, bool& limited) noexcept {
  const double size = force.norm();
  limited = !(size <= limits.max_force && std::isfinite(size));
  if (!std::isfinite(size)) return Vec3::Zero();
  return limited ? Vec3(limits.max_force / size * force) : force;
}

Vec3 interpolate_path(const std::vector<TimedPoint>& path, double t) noexcept {
  const auto after =
      std::upper_bound(path.begin(), path.end(), t, [](double a, const TimedPoint& p) { return a < p.t; });
  if (after == path.begin()) return path.front().x;
  if (after == path.end()) return path.back().x;
  const TimedPoint &a = *(after - 1), &b = *after;
  return a.x + (t - a.t) / (b.t - a.t) * (b.x - a.x);
}

double path_speed(const std::vector<TimedPoint>& path) noexcept {
  double speed = 0;
  for (std::size_t i = 1; i < path.size(); ++i)
    speed = std::max(speed, (path[i].x - path[i - 1].x).norm() / (path[i].t - path[i - 1].t));
  return speed;
}

}  // namespace kt
