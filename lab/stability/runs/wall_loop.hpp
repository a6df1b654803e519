#pragma once
// A simulated hand that presses a device into a virtual wall, tick by tick: the haptic loop at its barest.
#include <cstdint>
#include <span>
#include <string>

#include "haptics/device/hand_loop.hpp"
#include "lab/stability/map.hpp"

namespace kt {

struct WallRun {
  double ripple = 0;         ///< of the force in the last quarter of the run, peak to peak / the force at rest [-]
  double ripple_before = 0;  ///< the same a quarter earlier
  double swing = 0;          ///< of the tool in the last quarter, peak to peak [m]
  int damped_ticks = 0;      ///< of passivity control
  double returned = 0;       ///< most energy that the hand got back beyond what it had put in [J]
  double felt = 0;           ///< force at rest / depth of the device in the last quarter [N/m]
  double coupling = 0;       ///< stiffness of the virtual coupling at the end [N/m]
  std::uint64_t hash = 0;
};

/// The hand comes down 5 mm onto the wall in 0.1 s and stays 5 mm inside with its target, until what swings has had
/// time to die out.
/// @param most_damping  of passivity control [N s/m]; 0: none
WallRun press_wall(const HandLoop& loop, double most_damping);

/// The same with more between wall and device than passivity control.
WallRun press_wall(const HandLoop& loop, const HandPort& port);

/// Forces that should have come to rest: fails when they swing on or the tool bounces; degrades while a swing that dies
/// out can be felt, or the encoder's steps.
MapVerdict judge_ripple(const WallRun& run, std::string& why);

/// Highest minus lowest, and mean size, of the values in [from, to) of all [share].
struct Swing {
  double size = 0, mean = 0;
  double ripple() const { return mean > 0 ? size / mean : 0; }
};
Swing swing_of(std::span<const double> values, double from, double to);

}  // namespace kt
