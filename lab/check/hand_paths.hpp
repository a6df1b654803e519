#pragma once
// How the tool of a check moves: as a hand does, from rest to rest with the least jerk.
#include <vector>

#include "haptics/device/haptic_device.hpp"
#include "lab/check/contact_spots.hpp"

namespace kt {

/// Of a line through these points.
double length_of(const std::vector<Vec3>& line);

/// Down onto the spot, in by steps of a quarter of its depth, each from rest to rest as a hand moves, and out again.
struct PressPath {
  std::vector<TimedPoint> path;
  std::vector<double> rests;  ///< when the rest at each depth ends [s]
  double pressed = 0;         ///< when it is all in [s]
};
PressPath press_path(const ContactSpot& spot);

/// Down to the start of a walk, then along it, there and back, until `duration` [s]: from rest to rest, with `speed`
/// on average [m/s].
std::vector<TimedPoint> drag_path(const ContactSpot& spot, const std::vector<Vec3>& walk, double speed,
                                  double duration);
constexpr double kDragPressTime = 0.12;  ///< [s] until the drag begins

}  // namespace kt
