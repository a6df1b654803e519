#pragma once
// Every force of every device goes through here, in one order: finite, coupling, passivity, gate, slew, clamp, booking.
// On the device's side of any scaling: what a hand is given.
//
// A device that somebody holds (DeviceInfo::is_live) has a gate. It is shut until the device is healthy, its button is
// held, and the tool is outside the body or being let out; it opens over half a second, and shuts so fast that the
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
  double most_damping = 0;            ///< that passivity control may add [N s/m]; 0: it only watches
  double scale = 1;                   ///< way of the tool / way of the device
  double force_scale = 1;             ///< force at the device / force on the tool
  std::optional<double> max_force{};  ///< [N]; none: 3 N of a live device; the device's own limit holds as well
  double max_slew = 200;              ///< [N/s] of a live device
  unsigned deadman = 0;               ///< buttons of which one has to be held; 0: none
  double damping = 0;                 ///< of the device, as its user has measured it [N s/m]; 0: as the device tells
  std::optional<double> delay{};      ///< until a force acts [s]; none: as the device tells, or measured
  bool fades_when_stale = false;      ///< a device that nobody holds has a gate, too, for local models that do not come
  std::optional<double> coupling{};   ///< between device and tool [N/m]; 0: none; not given: chosen, of a live device
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

/// What the chain did so far, in ticks.
struct SafetyCounts {
  int ticks = 0;
  int not_finite = 0;  ///< force or torque asked for was no number
  int limited = 0;     ///< cut to what the device can give, or may give for long
  int slewed = 0;      ///< held back from rising faster than max_slew
  int gated = 0;       ///< with the gate not fully open
  int stale = 0;       ///< whose pose was too old, or the device not there
  int shut = 0;        ///< how often an open gate began to shut
  int jumps = 0;       ///< how often a pose leapt as no hand moves
  int unechoed = 0;    ///< with a force that the device, which repeats what it is sent, did not repeat
  std::array<int, kGateReasons> by_reason{};  ///< with the gate shutting or shut, by its GateReason
  double most_force = 0;                      ///< written [N]
  std::optional<double> most_echoed{};        ///< that the device has repeated [N]; none: it repeats nothing
  double most_slew = 0;                       ///< from tick to tick [N/s]
};

/// Why the gate was shut in most of its ticks; `open`: it was not.
GateReason main_reason(const SafetyCounts& counts) noexcept;

/// It can be moved, and not be copied.
class SafetyChain {
 public:
  explicit SafetyChain(const SafetyOptions& options);
  ~SafetyChain();
  SafetyChain(SafetyChain&&) noexcept;
  SafetyChain& operator=(SafetyChain&&) noexcept;

  /// The tool is there now, wherever the device is: it goes to the device as after a gap.
  void begin_at(const Vec3& tool) noexcept;

  /// Where the tool goes for a device that is there, in the world's frame: there, but for the coupling's stretch. After
  /// a gap in the poses, a leap, and at the start, it follows the way that it missed (FollowedPose), with the gate
  /// shut. Before the tick; who leaves it out has no coupling, and no guard against leaps.
  /// @param dt  since the last call [s], > 0
  Pose tool(const Pose& device, double dt) noexcept;

  /// After the tick. What to write to the device for the frame, whose force, torque and flags become what was really
  /// given (the force at the tool's scale). No allocation, no clock.
  /// @param device  where the device is, in the world's frame and at the tool's scale
  /// @param dt      since the last call [s], > 0
  Wrench make_safe(LocalFrame& frame, const Pose& device, const DeviceState& state, double dt) noexcept;

  /// The process ends, or the tool is put down: the gate shuts and stays so.
  void shut() noexcept;

  double gate() const noexcept;  ///< 0 shut .. 1 open
  GateReason reason() const noexcept;
  GateReason last_reason() const noexcept;  ///< the last that was not `open`
  const SafetyCounts& counts() const noexcept;
  const PassivityControl* passivity() const noexcept;  ///< null: none
  /// Of the torque, over the turns: of a live device that gives one; null: none.
  const PassivityControl* turning() const noexcept;
  double coupling() const noexcept;  ///< [N/m] at the device; 0: none
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
