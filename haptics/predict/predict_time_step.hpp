#pragma once
// Explicit steps beyond the limit of the body's fastest mode.
#include <optional>

#include "core/global/integrator.hpp"
#include "haptics/predict/predict.hpp"

namespace kt {

/// None when `integrator` (core/global/integrators.def) is stable at steps of dt [s] on the body at `state`, of which
/// fastest_mode() is taken.
/// @param setting  the integrator's key in the scene, for the message
std::optional<Prediction> predict_unstable_step(const DeformableModel& model, const State& state,
                                                const std::string& integrator, double dt,
                                                const std::string& setting = "global.integrator");

/// The same for a mode that is known.
std::optional<Prediction> predict_unstable_step(const FastestMode& mode, const std::string& integrator, double dt,
                                                const std::string& setting = "global.integrator");

}  // namespace kt
