#pragma once
// What goes over the wire between us and Haply's Inverse Service 3.x: JSON, SI units, right-handed, z up. Facts:
// docs.haply.co, inverseSDK/service/ (3.5): realtime/websocket-protocol, commons/mount-and-workspace, events.
#include <optional>
#include <string>
#include <vector>

#include "haptics/driver/device_slots.hpp"

namespace kt {

/// Under which name a service takes a force: `vector` since 3.5, `values` before. Each ignores the other's.
enum class HaplyKey { vector, values };
const char* name_of(HaplyKey key) noexcept;

/// What an Inverse3 says of itself; what is missing is well.
struct HaplyStatus {
  bool has_power = true, is_calibrated = true, is_ready = true, is_started = true, is_in_use = false;
};

/// One Inverse3 that is listed.
struct HaplyListed {
  std::string id, type;  ///< type: inverse3, inverse3x, minverse; a model's name of old services; or ""
  HaplyStatus status;
};

/// One message from the service. What is missing, or is no finite number, is not there; unknown keys are left out.
struct HaplyState {
  std::vector<HaplyListed> devices;
  bool has_list = false;              ///< it says which devices there are
  bool is_full = false;               ///< with the chosen device's configuration: `altered` and `grip` are told
  std::string altered;                ///< what of it is not ours, as "mount.scale 2 2 2"; empty: nothing
  std::optional<HaplyStatus> status;  ///< of the chosen device; none: it is not listed
  std::optional<Vec3> x, v, force;    ///< cursor [m], [m/s]; the force that was commanded last [N]
  std::size_t grips = 0;              ///< that are listed
  std::string grip;                   ///< of the device: the one that is paired with it, or the only one; else empty
  std::optional<Quaternion> turn;     ///< of that grip
  std::uint64_t buttons = 0;          ///< of that grip: a b c are bits 0 1 2
  HaplyKey key = HaplyKey::values;    ///< that a service which writes such messages is likely to take
};

/// @param id    of the device whose state is wanted; empty: the first
/// @param grip  of which turn and buttons are wanted; empty: as `grip` of the message itself
/// Throws InputError for what is no JSON object.
HaplyState read_haply_state(const std::string& message, const std::string& id, const std::string& grip = {});

/// "Inverse3", "Minverse" ... of a type; an old model's name as it is.
std::string haply_name(const std::string& type);
/// [m] from the middle of its workspace.
double haply_reach(const std::string& type) noexcept;

/// First message to a device: our name, axes and place as they are, what the service adds by itself, and no force.
std::string haply_greeting(const std::string& id, double service_damping, HaplyKey key);
/// What the greeting cannot hold beside a preset, mount and transform as they are; asks for all that is there.
std::string haply_identities(const std::string& id, double service_damping);
/// @param force [N], finite
std::string haply_force(const std::string& id, const double (&force)[3], HaplyKey key);
/// Asks for the state and commands nothing. An empty id: of all; `is_full`: with their configuration.
std::string haply_question(const std::string& id, bool is_full);

/// A setting of the service, as its HTTP channel answers; none: it is not in there.
std::optional<double> read_haply_setting(const std::string& answer, const std::string& key);

/// One message from the channel of events.
struct HaplyEvent {
  std::string name, level, device, kind, message;  ///< kind: of a safety event
};
/// Throws InputError for what is no JSON object.
HaplyEvent read_haply_event(const std::string& message);

}  // namespace kt
