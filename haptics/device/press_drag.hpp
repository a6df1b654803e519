#pragma once
// The standard path: come down on the body, press, then drag along it at a constant depth below its rest surface.
#include <optional>

#include "collision/shape/contact.hpp"
#include "core/body/mesh.hpp"
#include "haptics/device/haptic_device.hpp"

namespace kt {

struct PressDragOptions {
  int axis = 2;                              ///< pressing goes against this axis: 0 x, 1 y, 2 z
  std::optional<std::array<double, 2>> at;   ///< the other two coordinates, in order [m]; absent: chosen
  double depth = 0.004;                      ///< below the place where the tool first touches [m]
  double press_time = 0.2;                   ///< [s]
  Vec3 direction = Vec3::UnitX();            ///< of the drag; its part along the axis is dropped
  double speed = 0.05;                       ///< across the axis [m/s]
  double duration = 1.0;                     ///< [s]
  double clearance = 0.002;                  ///< the path starts this far above the surface [m]
  Quaternion turn = Quaternion::Identity();  ///< of the tool
  bool eased = false;  ///< the tool starts, turns and stops with least jerk; else its speed changes at once
  std::vector<TimedPoint> other = {};  ///< path of another tool: a place that is chosen stays clear of it,
  double apart = 0;                    ///< by this at any time [m]
};

/// Eased: down from rest to rest (Flash and Hogan 1985), then from end to end at the given speed, which it takes up and
/// gives up within 0.1 s.
/// The tool touches where it would if dropped along the axis; it turns round where the surface ends, becomes
/// steeper than 31 degrees, or where the body is thinner than three depths. Throws InputError when the tool, dropped
/// there, misses the body, and when no place is clear of the other tool.
std::vector<TimedPoint> make_press_drag(const Mesh& mesh, const ToolShape& tool, const PressDragOptions& options);

}  // namespace kt
