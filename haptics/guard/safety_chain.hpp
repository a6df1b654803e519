#pragma once
// Every force of every device goes through here in the order finite, coupling, passivity, gate, slew, clamp, booking.
// It is on the device's side of any scaling, so its forces are those of the hand.
//
// A device that somebody holds (DeviceInfo::is_live) has a gate. It is shut until the device is healthy, its button is
// held, and the tool is outside the body or being let out. It opens over half a second, and shuts so fast that the
// force is zero 20 ms after the last fresh pose.
#include <array>
#include <memory>
#include <optional>

#include "haptics/device/haptic_device.hpp"
#include "haptics/tick/local_frame.hpp"

namespace kt {

class PassivityControl;  // haptics/safety/passivity.hpp

struct SafetyOptions {
  DeviceInfo device{};
  double h = 1e-3;                    ///< tick [s]
  double most_damping = 0;            ///< most that passivity control may add [N s/m]. With 0 it only watches
  double scale = 1;                   ///< way of the tool / way of the device
  double force_scale = 1;             ///< force at the device / force on the tool
  std::optional<double> max_force{};  ///< [N], 3 N by default of a live device. The device's own limit holds as well
  double max_slew = 200;              ///< [N/s] of a live device
  unsigned deadman = 0;               ///< buttons of which one has to be held, 0 for none
  double damping = 0;  ///< damping of the device, measured by its user [N s/m], 0 for the device's own figure
  std::optional<double> delay{};     ///< delay until a force acts [s], by default the device's own figure, or measured
  bool fades_when_stale = false;     ///< a device that nobody holds has a gate, too, for local models that do not come
  std::optional<double> coupling{};  ///< stiffness between device and tool [N/m], 0 for none, chosen by default
};

/// Why a gate is shut.
enum class GateReason {
  open,
  stale_pose,
  gone,
  fault,
  uncalibrated,
  button,
  no_model,
  stale_model,
  inside,
  on_the_way,
  late_ticks,
  put_down,
  bad_pose,
  jumped,
  unpowered,
  not_ready,
  in_use,
  altered,
  no_echo,
};
constexpr std::size_t kGateReasons = 19;
const char* name_of(GateReason reason) noexcept;

/// Counts of ticks so far.
struct SafetyCounts {
  int ticks = 0;
  int not_finite = 0;                         ///< force or torque was no number
  int limited = 0;                            ///< cut to the device's limit, of any time or for long
  int slewed = 0;                             ///< held back from rising faster than max_slew
  int gated = 0;                              ///< with the gate not fully open
  int stale = 0;                              ///< whose pose was too old, or the device not there
  int shut = 0;                               ///< how often an open gate began to shut
  int jumps = 0;                              ///< how often a pose leapt as no hand moves
  int unechoed = 0;                           ///< with a force that the device did not repeat, though it repeats forces
  std::array<int, kGateReasons> by_reason{};  ///< with the gate shutting or shut, by its GateReason
  double most_force = 0;                      ///< written [N]
  std::optional<double> most_echoed{};  ///< largest that the device has repeated [N], none where it repeats nothing
  double most_slew = 0;                 ///< from tick to tick [N/s]
};

/// The reason of the shut gate in most of its ticks, `open` where it was not shut.
GateReason main_reason(const SafetyCounts& counts) noexcept;

/// It can be moved, and not be copied.
class SafetyChain {
 public:
  explicit SafetyChain(const SafetyOptions& options);
  ~SafetyChain();
  SafetyChain(SafetyChain&&) noexcept;
  SafetyChain& operator=(SafetyChain&&) noexcept;

  /// The tool is there now, at any pose of the device, and goes to the device as after a gap.
  void begin_at(const Vec3& tool) noexcept;

  /// Pose of the tool for a device at that pose, in the world's frame. They differ by the coupling's stretch. After
  /// a gap in the poses, a leap, and at the start, the tool follows the way that it missed (FollowedPose), with the
  /// gate shut. Called before the tick. Without the call there is no coupling, and no guard against leaps.
  /// @param dt  time since the last call [s], > 0
  Pose tool(const Pose& device, double dt) noexcept;

  /// Called after the tick. Returns the force to write to the device for the frame, whose force, torque and flags
  /// become those really given (the force at the tool's scale). No allocation, no clock.
  /// @param device  pose of the device, in the world's frame and at the tool's scale
  /// @param dt      time since the last call [s], > 0
  Wrench make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state, double dt) noexcept;

  /// Shuts the gate for good, as the process ends or the tool is put down.
  void shut() noexcept;

  double gate() const noexcept;  ///< 0 shut .. 1 open
  GateReason reason() const noexcept;
  GateReason last_reason() const noexcept;  ///< the last that was not `open`
  const SafetyCounts& counts() const noexcept;
  const PassivityControl* passivity() const noexcept;  ///< null for none
  /// Passivity of the torque over the turns, for a live device that gives one, else null.
  const PassivityControl* turning() const noexcept;
  double coupling() const noexcept;  ///< [N/m] at the device, 0 for none
  const DelayEstimate& delay() const noexcept;
  double max_force() const noexcept;  ///< [N] at the device

  static constexpr double kZeroWithin = 20e-3;  ///< [s] after the last fresh pose, or the last tick
  static constexpr double kOpening = 0.5;       ///< [s]
  static constexpr double kFollows = 0.25;      ///< [m/s] of a tool that follows the way it missed

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
