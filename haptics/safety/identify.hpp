#pragma once
// Damping, mass and delay of a device, from how it swings by itself on a rendered spring.
//
// Hands off, the device obeys m x'' + b x' = f(t - T_d), f the held force that was written. Integrated twice, there is
// nothing to differentiate that an encoder has rounded: m x + b int x + c t + d = int int f(t - T_d), linear in m, b
// and the start (c, d) for each T_d; T_d is where the sum of squares is smallest. A spring's force alone would hardly
// tell delay from damping (K T_d x' looks like -b x'): its jump at the release does.
#include <span>
#include <string>

namespace kt {

/// One tick of a release along one axis.
struct ReleaseSample {
  double t = 0;      ///< [s], ascending
  double x = 0;      ///< read then [m]
  double force = 0;  ///< written then, and held until the next [N]; before the first: none
};

struct DeviceFit {
  double damping = 0, mass = 0, delay = 0;                    ///< b [N s/m], m [kg], T_d [s]
  double damping_error = 0, mass_error = 0, delay_error = 0;  ///< two standard deviations
  double residual = 0;                                        ///< RMS of what the model leaves of the position [m]
  double swing = 0;                                           ///< largest minus smallest position [m]
  std::string refusal;                                        ///< why the figures are not to be used; empty: they are
  bool is_good() const { return refusal.empty(); }
};

/// The spring that `kilotouch device identify` renders [N/m]: soft enough for any device to hold for a second.
constexpr double kReleaseStiffness = 100;

/// Best fit to a release: the device at rest, then drawn by a spring whose rest place has jumped away. Refuses (in
/// words) a record that is too short, too still, or that this model does not explain: held, with dry friction, clipped.
/// @param samples       some 0.5 to 2 s, from the jump on
/// @param encoder_step  [m]; 0: unknown
/// @param most_delay    that is looked for [s]
DeviceFit fit_release(std::span<const ReleaseSample> samples, double encoder_step = 0, double most_delay = 0.02);

}  // namespace kt
