#pragma once
// The table of maps (maps.def) and how to make one.
#include "lab/stability/map.hpp"

namespace kt {

struct MapEntry {
  std::string name, title;
  StabilityMap (*make)(const MapOptions& options);
};

/// In the order of the table.
const std::vector<MapEntry>& stability_maps();

/// The entries of the given names, in the table's order; all without names. Throws InputError for an unknown name.
std::vector<MapEntry> find_maps(const std::vector<std::string>& names);

/// Runs one map and measures its wall clock.
StabilityMap make_map(const MapEntry& entry, const MapOptions& options);

}  // namespace kt
