#pragma once
// What goes over the wire between us and Haply's Inverse Service 3.x: JSON, SI units, right-handed, z up. Facts:
// docs.haply.co, inverseSDK/service/realtime/websocket-protocol (3.5).
#include <optional>
#include <string>
#include <vector>

#include "haptics/driver/device_slots.hpp"

namespace kt {

/// One message from the service. What is missing, or is no finite number, is not there; unknown keys are left out.
struct HaplyState {
  std::vector<std::string> devices, models;  ///< Inverse3 that are listed: their ids; what they say they are, or ""
  std::optional<Vec3> x, v, force;           ///< of the chosen device: cursor [m], [m/s], the force that acts now [N]
  std::optional<Quaternion> turn;            ///< of the first grip
  std::uint64_t buttons = 0;                 ///< of that grip: a b c are bits 0 1 2
  bool is_calibrated = true;
};

/// @param id  of the device whose state is wanted; empty: the first
/// Throws InputError for what is no JSON object.
HaplyState read_haply_state(const std::string& message, const std::string& id);

/// First message to a device: our name, axes as they are, what the service adds by itself.
std::string haply_greeting(const std::string& id, double service_damping);
/// @param force [N], finite
std::string haply_force(const std::string& id, const double (&force)[3]);
/// Asks for all that is there.
std::string haply_question();

}  // namespace kt
