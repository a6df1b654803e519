#pragma once
// From one local model to the next: motion, contacts and force go on.
#include "haptics/tick/tick_state.hpp"

namespace kt {

/// From now on `now`: patch motion and contacts are carried over by node and triangle, unless it is caught up already.
/// @param old  in use until now; none: there was none
void change_model(TickState& tick, PreparedLocalModel& now, const PreparedLocalModel* old) noexcept;

}  // namespace kt
