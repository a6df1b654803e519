#pragma once
// Single points of maps, for the tests that assert where a method fails.
#include "lab/stability/map.hpp"

namespace kt {

/// A ball of 1 mm at that speed straight down through a sheet of that thickness (tunnelling.cpp): of three phases
/// within a tick the worst.
MapPoint shoot_at_sheet(const std::string& method, double speed, double thickness, const MapOptions& options = {});

/// A drag over the slab with local models that come late or not at all (refresh.cpp).
MapPoint drag_with_late_models(double rate_hz, double latency_ms, double loss, const MapOptions& options = {});

}  // namespace kt
