#include "lab/stability/maps.hpp"

#include <algorithm>
#include <chrono>

#include "core/base/error.hpp"

namespace kt {

#define MAP(name, title) StabilityMap map_##name(const MapOptions& options);
#include "lab/stability/maps.def"

const std::vector<MapEntry>& stability_maps() {
  static const std::vector<MapEntry> table = {
#define MAP(name, title) {#name, title, map_##name},
#include "lab/stability/maps.def"
  };
  return table;
}

std::vector<MapEntry> find_maps(const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const MapEntry& e : stability_maps()) known.push_back(e.name);
  for (const std::string& name : names)
    if (std::ranges::find(known, name) == known.end()) throw_unknown("map", name, known);
  std::vector<MapEntry> out;
  for (const MapEntry& e : stability_maps())
    if (names.empty() || std::ranges::find(names, e.name) != names.end()) out.push_back(e);
  return out;
}

StabilityMap make_map(const MapEntry& entry, const MapOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  StabilityMap out = entry.make(options);
  out.name = entry.name;
  out.title = entry.title;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace kt
