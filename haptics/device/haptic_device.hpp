#pragma once
// The source of the tool's pose, and the sink of its force. Backends are in device.def.
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/settings.hpp"
#include "core/base/types.hpp"

namespace kt {

class MovedTarget;   // haptics/device/moved_target.hpp
struct DeviceSlots;  // haptics/driver/device_slots.hpp

/// Properties of a device, as far as they are known. Forces and ways are the device's own, before any scaling.
struct DeviceInfo {
  double max_force = std::numeric_limits<double>::infinity();  ///< [N]
  double delay = 0;                                            ///< from write() until the force acts [s]
  bool yields = false;        ///< it moves with the force, and energy goes back and forth
  bool gives_torque = false;  ///< else the torque that is written goes nowhere
  bool is_live = false;       ///< held by a person, so that every force is made safe
  bool gives_force = true;    ///< else it is moved and nothing is felt
  bool senses_turn = false;   ///< its poses have an orientation
  // 0 for not known.
  double max_torque = 0;        ///< [N m]
  double continuous_force = 0;  ///< force without a limit of time [N]
  double max_stiffness = 0;     ///< the maker's figure [N/m]
  double max_damping = 0;       ///< the same [N s/m]
  double damping = 0;           ///< own damping [N s/m]
  double encoder_step = 0;      ///< [m]
  double workspace_radius = 0;  ///< [m]
  std::string name{}, serial{};
  Vec3 pen_turn = Vec3::Zero();       ///< rotation vector that lays a tool along the stylus, its tip at -z [rad]
  bool delay_is_of_messages = false;  ///< it tells the way of a message, and nothing of its motors
};

/// Whether a device's poses can be relied upon now.
enum class DeviceHealth {
  ok,
  stale,
  gone,
  fault,
  uncalibrated,
  bad_pose,  ///< it is no number
  unpowered,
  not_ready,
  in_use,   ///< by another program
  altered,  ///< a service between program and motors changes places or forces
  no_echo,  ///< a force was sent, and is not repeated
};
const char* name_of(DeviceHealth health) noexcept;

/// State of a device at the pose that was taken last.
struct DeviceState {
  DeviceHealth health = DeviceHealth::ok;
  double age = 0;                  ///< age of the pose [s]
  unsigned buttons = 0;            ///< bit 0 is the first
  double delay = 0;                ///< from a force that was written until it acted, as the device told last [s]
  unsigned delays = 0;             ///< how many were told
  std::optional<Vec3> v{};         ///< the device's own velocity, in the world's frame, at the device's scale [m/s]
  std::optional<double> echoed{};  ///< |force| that the device repeats now [N], none where it repeats nothing
  double most_echoed = 0;          ///< largest so far [N]
};

/// A delay for a controller, and how well it is known.
struct DelayEstimate {
  double delay = 0;         ///< [s] to reckon with
  double p50 = 0, p99 = 0;  ///< percentiles of the acknowledgements in the window [s], 0 before there are enough
  bool measured = false;    ///< else fixed or unknown
};

/// A device in the world frame. pose(), state() and write() run in the haptic tick, without allocation or exception.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// Pose of the tool at time t [s]. Called with ascending t, once a tick.
  virtual Pose pose(double t) noexcept = 0;
  virtual DeviceState state() const noexcept { return {}; }
  virtual Vec3 origin() const { return Vec3::Zero(); }  ///< place of the device's own zero [m]
  /// Takes the wrench on the tool for the next h [s], of a live device at the device's scale, along the world's axes.
  /// Callers pass it through SafetyChain first.
  virtual void write(const Wrench& wrench, double h) noexcept = 0;
  virtual DeviceInfo info() const = 0;
  /// Messages of its driver so far, a line each. Not in the tick.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Upper bound of the speed [m/s], which bounds the way until the next refresh.
  virtual double max_speed() const = 0;
};

/// A point of a path at a time.
struct TimedPoint {
  double t = 0;           ///< [s]
  Vec3 x = Vec3::Zero();  ///< [m]
  bool operator==(const TimedPoint&) const = default;
};

/// A pose at a time, as recordings have them.
struct TimedPose {
  double t = 0;  ///< [s]
  Pose pose{};
  bool operator==(const TimedPose&) const = default;
};

struct DeviceOptions {
  std::vector<TimedPoint> path{};  ///< path of scripted and recorded, target of hand. Ascending t, linear in between
  ToolTurn turn{};                 ///< turn of all three, beside the path. Recorded poses have their own
  std::vector<TimedPose> poses{};  ///< poses of recorded, instead of path and turn
  std::string recording{};         ///< file of recorded, read when there is neither path nor poses
  double h = 1e-3;                 ///< haptic step [s]
  // The hand, a mass held to the target by a spring and a damper
  double hand_stiffness = 300, hand_damping = 3, hand_mass = 0.1;  ///< [N/m], [N s/m], [kg]
  double hand_delay = 0;                  ///< [s] from write() to the motors, through bus, driver, amplifier
  double encoder_step = 1e-5;             ///< [m] positions are read in multiples of this, 0 for exact ones
  double max_force = 7.9;                 ///< [N] largest force of the simulated device
  std::shared_ptr<MovedTarget> target{};  ///< target of hand, moved by another thread, not by the path
  DeviceInfo info = {};                   ///< recorded device
  DeviceSettings live{};                  ///< settings of a live device
  Vec3 over = Vec3::Zero();               ///< place of the tool when a live device without an origin is opened [m]
  std::shared_ptr<DeviceSlots> slots{};   ///< slots of pushed that the user's own loop fills, new ones by default
};

std::unique_ptr<HapticDevice> make_device(const std::string& name, const DeviceOptions& options);

/// The force that may be written to a device. One that is too large is cut to the limit in its direction (limited =
/// true), never above it by rounding. Zero when a component is not finite (then limited = true as well).
Vec3 safe_force(const Vec3& force, const DeviceInfo& device, bool& limited) noexcept;

/// Position on a path at time t. Its ends hold.
Vec3 interpolate_path(const std::vector<TimedPoint>& path, double t) noexcept;

/// Pose on a path at time t. Its ends hold, in between the tool turns evenly the short way.
Pose interpolate_poses(const std::vector<TimedPose>& path, double t) noexcept;

/// Smallest distance of two tools on their paths at the same time [m].
double least_distance(const std::vector<TimedPoint>& a, const std::vector<TimedPoint>& b) noexcept;

/// Largest speed between neighbouring points [m/s].
double path_speed(const std::vector<TimedPoint>& path) noexcept;

}  // namespace kt
