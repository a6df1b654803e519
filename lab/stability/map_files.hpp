#pragma once
// Maps as files: <map>.csv, <map>_boundaries.csv, stability.json.
#include <nlohmann/json_fwd.hpp>

#include "lab/stability/map.hpp"

namespace kt {

/// series,x,y,verdict,why,value,predicted_failure,prediction,hash: one row a point.
std::string points_csv(const StabilityMap& map);

/// series,label,theory,x,y: one row a point of a line, lines one after the other.
std::string boundaries_csv(const StabilityMap& map);

/// One map without its points: axes, claim, wall clock, confusion counts, hash over all points.
nlohmann::ordered_json map_json(const StabilityMap& map);

nlohmann::ordered_json confusion_json(const Confusion& confusion);

/// DIR/<map>.csv and DIR/<map>_boundaries.csv.
void write_map(const std::string& dir, const StabilityMap& map);

}  // namespace kt
