#pragma once
// Where the tool is, and where its force goes. Backends: device.def.
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/backend.hpp"
#include "core/types.hpp"

namespace kt {

struct DeviceLimits {
  double max_force = std::numeric_limits<double>::infinity();  ///< [N]
  double delay = 0;                                            ///< from write() until the force acts [s]
  bool yields = false;                                         ///< it moves with the force: energy goes back and forth
};

/// A device in the world frame. position() and write() run in the haptic tick: no allocation, no exception.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// Position at time t [s]; called with ascending t, once a tick.
  virtual Vec3 position(double t) noexcept = 0;
  /// Takes the tool's force [N] for the next h [s]. Callers pass it through safe_force first.
  virtual void write(const Vec3& force, double h) noexcept = 0;
  virtual DeviceLimits limits() const = 0;
  /// Upper bound of the speed [m/s]: how far the tool gets until the next refresh.
  virtual double max_speed() const = 0;
};

/// A point of a path at a time.
struct TimedPoint {
  double t = 0;           ///< [s]
  Vec3 x = Vec3::Zero();  ///< [m]
  bool operator==(const TimedPoint&) const = default;
};

struct DeviceOptions {
  std::vector<TimedPoint> path;  ///< scripted, recorded: the path; hand: its target; ascending t, linear in between
  std::string recording;         ///< recorded: file with "t,x,y,z" rows, read when there is no path
  double h = 1e-3;               ///< haptic step [s]
  // hand: a mass held to the target by a spring and a damper
  double hand_stiffness = 300, hand_damping = 3, hand_mass = 0.1;  ///< [N/m], [N s/m], [kg]
  double hand_delay = 0;       ///< [s] from write() to the motors: bus, driver, amplifier
  double encoder_step = 1e-5;  ///< [m] positions are read in multiples of this; 0: exact
  double max_force = 7.9;      ///< [N] what the simulated device can give
  DeviceLimits limits = {};    ///< recorded: of the device that was played on
};

std::vector<BackendInfo> device_backends();
std::unique_ptr<HapticDevice> make_device(const std::string& name, const DeviceOptions& options);

/// What may be written to a device: the force, or of one that is too large the limit in its direction (limited = true),
/// never above it by rounding; zero when a component is not finite (then limited = true as well).
Vec3 safe_force(const Vec3& force, const DeviceLimits& limits, bool& limited) noexcept;

/// Position on a path at time t; its ends hold.
Vec3 interpolate_path(const std::vector<TimedPoint>& path, double t) noexcept;

/// Smallest distance of two tools on their paths at the same time [m].
double least_distance(const std::vector<TimedPoint>& a, const std::vector<TimedPoint>& b) noexcept;

/// Largest speed between neighbouring points [m/s].
double path_speed(const std::vector<TimedPoint>& path) noexcept;

}  // namespace kt
