#pragma once
// Independent rays of a map on several threads.
#include <functional>
#include <optional>

#include "haptics/predict/predict.hpp"
#include "lab/stability/map.hpp"

namespace kt {

/// A point before its run, and what the engine foresees of it.
MapPoint point_at(const std::string& series, double x, double y, const std::optional<Prediction>& foreseen = {});

/// What one ray finds.
struct RayResult {
  std::vector<MapPoint> points;
  std::vector<MapBoundary> boundaries;  ///< pieces: those of one series, label and kind are joined in the order of rays
};

/// Calls ray(i) for i = 0 .. count - 1 from `options.jobs` threads and adds the results to `map` in the order of i,
/// whichever ends first. After a stop the rays that have not begun are left out. An exception of a ray is thrown again
/// here.
void run_rays(const MapOptions& options, int count, const std::function<RayResult(int)>& ray, StabilityMap& map);

}  // namespace kt
