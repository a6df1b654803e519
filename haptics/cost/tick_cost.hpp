#pragma once
// What a haptic tick will take.
#include "core/local/local_model.hpp"
#include "haptics/cost/expected_touch.hpp"

namespace kt {

/// CPU time of a haptic tick [us], from sizes alone, so that the same scene chooses the same everywhere: fitted to
/// measured ticks of a core of 2.1 GHz (docs/accuracy_and_speed.md#what-is-predicted-of-a-tick). Without contact, or
/// where `touch` has places in contact.
double predict_tick_us(const LocalModel& model, const ExpectedTouch& touch = {});
/// The part of it that contact takes, whatever the model.
double predict_contact_us(const ExpectedTouch& touch);

}  // namespace kt
