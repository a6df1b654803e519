#pragma once
#include "core/body/deformable_model.hpp"
#include "lab/stability/runs/rays.hpp"

namespace kt {

/// Where along the time step an explicit integrator's motion starts to grow: bisected to half a per cent between 1 us
/// and 1 s, every run a point of `series` at `x`; and where the fastest mode's limit (Lanczos) says.
RayResult find_explicit_limit(const DeformableModel& model, const std::string& integrator, const std::string& series,
                              double x);

constexpr const char* kMeasuredLimit = "limit, measured";

/// Largest relative distance between the lines measured and from theory, over all series that `holds` is true of; NaN
/// without any.
double distance_from_theory(const StabilityMap& map, const std::function<bool(const std::string&)>& holds);

}  // namespace kt
