#pragma once
// The tick of the consistent laws, by impulses: contacts are constraints on the end of the step. The surface point
// under the tool moves with it (docs/method.md#7-the-consistent-law).
#include "haptics/tick/tick_state.hpp"

namespace kt {

/// From the free motion to the state at the end of the tick.
void step_coulomb(TickState& tick, std::span<LocalFrame> frames) noexcept;

}  // namespace kt
