#pragma once
// A hand whose device, in a sampled loop with what it touches, will not come to rest.
#include <optional>

#include "haptics/device/hand_loop.hpp"
#include "haptics/predict/predict.hpp"

namespace kt {

/// None when the loop comes to rest. With passivity control: when it does with some damper up to `most_damping`.
std::optional<Prediction> predict_limit_cycle(const HandLoop& loop, double most_damping = 0);

/// The same with all that may stand between wall and device, told of a delay that need not be the true one.
std::optional<Prediction> predict_limit_cycle(const HandLoop& loop, const HandPort& port);

}  // namespace kt
