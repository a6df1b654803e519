#include "haptics/device/haptic_device.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/backend.hpp"
#include "haptics/device/device_backends.hpp"

namespace kt {

#define DEVICE(name, available, option, what) std::unique_ptr<HapticDevice> make_##name##_device(const DeviceOptions&);
#include "haptics/device/device.def"
#define KT_MAKE_IF_1(name) return make_##name##_device(options);
#define KT_MAKE_IF_0(name)
#define KT_MAKE_IF(available, name) KT_MAKE_IF_(available, name)
#define KT_MAKE_IF_(available, name) KT_MAKE_IF_##available(name)

std::vector<BackendInfo> device_backends() {
  return {
#define DEVICE(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/device/device.def"
  };
}

std::vector<BackendInfo> live_device_backends() {
  return {
#define DEVICE(name, available, option, what)
#define LIVE_DEVICE(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/device/device.def"
  };
}

const char* name_of(DeviceHealth health) noexcept {
  switch (health) {
    case DeviceHealth::ok:
      return "ok";
    case DeviceHealth::stale:
      return "stale";
    case DeviceHealth::gone:
      return "gone";
    case DeviceHealth::fault:
      return "fault";
    case DeviceHealth::uncalibrated:
      return "uncalibrated";
    case DeviceHealth::bad_pose:
      return "bad pose";
    case DeviceHealth::unpowered:
      return "without power";
    case DeviceHealth::not_ready:
      return "not ready";
    case DeviceHealth::in_use:
      return "in use";
    case DeviceHealth::altered:
      return "altered";
    case DeviceHealth::no_echo:
      return "no echo";
  }
  return "";
}

std::unique_ptr<HapticDevice> make_device(const std::string& name, const DeviceOptions& options) {
  require_backend("device", name, device_backends());
#define DEVICE(known, available, option, what) \
  if (name == #known) {                        \
    KT_MAKE_IF(available, known)               \
  }
#include "haptics/device/device.def"
  return nullptr;
}

Vec3 safe_force(const Vec3& force, const DeviceInfo& device, bool& limited) noexcept {
  limited = true;
  if (!force.allFinite()) return Vec3::Zero();
  // Of the order of one: squares of large and small forces are no numbers.
  const double largest = force.lpNorm<Eigen::Infinity>();
  const Vec3 way = largest > 0 ? Vec3(force / largest) : force;
  const double size = std::hypot(way.x(), way.y(), way.z());
  limited = size > device.max_force / largest || force.norm() > device.max_force;
  if (!limited) return force;
  constexpr double kRounding = 1e-15;  // of the few operations here: the result is never above the limit
  if (device.max_force < std::numeric_limits<double>::min() / kRounding) return Vec3::Zero();
  return (1 - kRounding) * device.max_force / size * way;
}

Vec3 interpolate_path(const std::vector<TimedPoint>& path, double t) noexcept {
  const auto after =
      std::upper_bound(path.begin(), path.end(), t, [](double a, const TimedPoint& p) { return a < p.t; });
  if (after == path.begin()) return path.front().x;
  if (after == path.end()) return path.back().x;
  const TimedPoint &a = *(after - 1), &b = *after;
  return a.x + (t - a.t) / (b.t - a.t) * (b.x - a.x);
}

Pose interpolate_poses(const std::vector<TimedPose>& path, double t) noexcept {
  const auto after =
      std::upper_bound(path.begin(), path.end(), t, [](double a, const TimedPose& p) { return a < p.t; });
  if (after == path.begin()) return path.front().pose;
  if (after == path.end()) return path.back().pose;
  const TimedPose &a = *(after - 1), &b = *after;
  const double share = (t - a.t) / (b.t - a.t);
  return {a.pose.x + share * (b.pose.x - a.pose.x), a.pose.r.slerp(share, b.pose.r)};
}

double least_distance(const std::vector<TimedPoint>& a, const std::vector<TimedPoint>& b) noexcept {
  double least = std::numeric_limits<double>::infinity();
  std::optional<Vec3> before;
  for (std::size_t i = 0, k = 0; i < a.size() || k < b.size();) {
    const bool is_first = k == b.size() || (i < a.size() && a[i].t <= b[k].t);
    const double t = is_first ? a[i++].t : b[k++].t;
    const Vec3 apart = interpolate_path(b, t) - interpolate_path(a, t);
    const Vec3 way = apart - before.value_or(apart);  // between two times both move evenly
    const double square = way.squaredNorm();
    const double back = square > 0 ? std::clamp(apart.dot(way) / square, 0.0, 1.0) : 0;
    least = std::min(least, (apart - back * way).norm());
    before = apart;
  }
  return least;
}

double path_speed(const std::vector<TimedPoint>& path) noexcept {
  double speed = 0;
  for (std::size_t i = 1; i < path.size(); ++i)
    speed = std::max(speed, (path[i].x - path[i - 1].x).norm() / (path[i].t - path[i - 1].t));
  return speed;
}

}  // namespace kt
