#pragma once
// The tick of the paper's laws, by positions: the surface is put under the tool, the forces there are computed, and the
// operators decide what the tool feels and how the surface moves on.               Paper sections IV.A and V, figure 2.
// docs/method.md#6-the-papers-laws-528 names the function of each equation.
#include "haptics/tick/tick_state.hpp"

namespace kt {

/// From the free motion to the state at the end of the tick; these laws know one tool.
void step_paper(TickState& tick, LocalFrame& frame) noexcept;

}  // namespace kt
