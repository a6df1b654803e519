#pragma once
// Whether ticks wait for refreshes, what a refresh may take, and what it takes in a lockstep that charges it.
#include "haptics/options/touch_options.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// Local models arrive later than they were begun by the time that they take: ticks are against the wall clock, or as
/// if.
inline bool models_come_late(const TouchOptions& options) {
  return options.link.type == "thread" || options.link.type == "network" || options.link.charge_refreshes != "none";
}

/// CPU time that there is for a tick [us]: local.budget_us, and at rates above 4 kHz no more than four fifths of the
/// period.
double tick_budget_us(const TouchOptions& options);

/// CPU time that there is for a refresh [ms]; infinity: any.
double refresh_budget_ms(const TouchOptions& options);

/// Ticks until a local model is made, in a lockstep that charges its refresh.
/// @param measured_ms, predicted_ms  CPU time of the refresh
int charged_ticks(const TouchOptions& options, double measured_ms, double predicted_ms);

/// The refresh's CPU time that the lockstep goes by [ms]: measured, predicted, or as the scene gives it; 0: none.
double charged_ms(const TouchOptions& options, double measured_ms, double predicted_ms);

/// The scene in a lockstep where each local model is as late as its refresh takes on this machine: what a person gets.
Scene as_real_time(Scene scene);

}  // namespace kt
