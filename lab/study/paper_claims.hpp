#pragma once
// What the paper says of its three experiments, as numbers.                                    Paper section VI.
#include <span>

#include "haptics/tick/local_simulation.hpp"

namespace kt {

/// Of the drag's ticks that press, the share in which friction exceeds the normal force. A normal force that vanishes
/// shows nothing: those ticks count that press with a tenth of the mean at least; 0 without any.
/// @param from  where the drag begins [s]
double share_above_normal(std::span<const LocalFrame> frames, double from);

/// The largest drop of F_T within ten ticks of a transition that comes after ten ticks of sticking, as a share of F_T.
double largest_slip_drop(std::span<const LocalFrame> frames, double from);

/// Ticks of sliding with friction that come right after one of sticking.
int stick_to_slip(std::span<const LocalFrame> frames);

}  // namespace kt
