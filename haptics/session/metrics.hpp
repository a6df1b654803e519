#pragma once
// The quantities that every experiment reports; docs/method.md#8-what-is-measured.
#include <span>
#include <vector>

#include "core/base/percentile.hpp"
#include "haptics/tick/local_simulation.hpp"

namespace kt {

constexpr double kNoticeableForce = 0.10;  ///< just noticeable difference of forces, 7-10 % of them
constexpr double kForceFloor = 0.05;       ///< below this share a force is too weak beside the others to be judged

struct ForceMetrics {
  double mean_n = 0, max_n = 0, mean_t = 0, max_t = 0;  ///< [N], over the ticks in contact
  double max_t_over_n = 0;                              ///< largest |f_t| / f_n of any one contact
  double felt_t_over_n = 0;  ///< largest tangential / normal part of the force that was written, in ticks with
                             ///< one contact and a force above 5 % of the mean; 100 where it pulls
  double buzz = 0;           ///< RMS of the force above 100 Hz in steady contact (not within 5 ms
                             ///< of a refresh) / mean force
  double crossing_jump = 0;  ///< largest |dF| over 1 ms (a tick at least) at a triangle crossing / mean force
  double refresh_jump = 0;   ///< the same at a model refresh
  double energy_min = 0;     ///< min over t of the work done by the tool on the body [J]; < 0: energy came out
  int ticks_free = 0, ticks_stick = 0, ticks_slide = 0, ticks_frictional_slide = 0;
  int crossings = 0;      ///< changes of triangle in contact
  int lost_contacts = 0;  ///< times that contact ended while the tool was not moving away
};

/// @param steady_from  [s]: buzz and jumps are measured from here on, after the press
/// @param h            haptic step [s]
ForceMetrics measure_forces(std::span<const LocalFrame> frames, double steady_from, double h);

/// Values above `cutoff_hz`, zero phase: a second-order Butterworth high-pass run forward and backward.
std::vector<double> high_pass(std::span<const double> values, double cutoff_hz, double rate_hz);

}  // namespace kt
