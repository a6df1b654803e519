#include "lab/stability/map_files.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/body/state.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

std::string quoted(const std::string& words) {
  if (words.find_first_of(",\"\n") == std::string::npos) return words;
  std::string out = "\"";
  for (char c : words) {
    if (c == '"') out += '"';
    out += c == '\n' ? ' ' : c;
  }
  return out + '"';
}

std::string hex(std::uint64_t value) {
  char out[20];
  std::snprintf(out, sizeof out, "%016llx", static_cast<unsigned long long>(value));
  return out;
}

std::uint64_t hash_of(const StabilityMap& map) {
  StateHash hash;
  for (const MapPoint& p : map.points) {
    hash.add(p.x);
    hash.add(p.y);
    hash.add(static_cast<int>(p.verdict));
    hash.add(&p.hash, sizeof p.hash);
  }
  return hash.value();
}

}  // namespace

std::string points_csv(const StabilityMap& map) {
  std::string out = "series,x,y,verdict,why,value,predicted_failure,prediction,hash\n";
  for (const MapPoint& p : map.points) {
    out += quoted(p.series) + ',';
    append_number(out, p.x);
    out += ',';
    append_number(out, p.y);
    out += ',' + std::string(word(p.verdict)) + ',' + quoted(p.why) + ',';
    append_number(out, p.value);
    out += std::string(p.predicted_failure ? ",1," : ",0,") + quoted(p.prediction) + ',' + hex(p.hash) + '\n';
  }
  return out;
}

std::string boundaries_csv(const StabilityMap& map) {
  std::string out = "series,label,theory,x,y\n";
  for (const MapBoundary& b : map.boundaries)
    for (const auto& [x, y] : b.points) {
      out += quoted(b.series) + ',' + quoted(b.label) + (b.theory ? ",1," : ",0,");
      append_number(out, x);
      out += ',';
      append_number(out, y);
      out += '\n';
    }
  return out;
}

nlohmann::ordered_json confusion_json(const Confusion& c) {
  return {{"points", c.points},
          {"failures", c.failures},
          {"predicted", c.predicted},
          {"degraded", c.degraded},
          {"degraded_warned", c.degraded_warned},
          {"working", c.working},
          {"false_alarms", c.false_alarms},
          {"alarms", c.alarms()}};
}

nlohmann::ordered_json map_json(const StabilityMap& map) {
  return {{"name", map.name},
          {"title", map.title},
          {"x_name", map.x_name},
          {"y_name", map.y_name},
          {"x_log", map.x_log},
          {"y_log", map.y_log},
          {"claim", map.claim},
          {"seconds", map.seconds},
          {"confusion", confusion_json(count_predictions(map.points))},
          {"hash", hex(hash_of(map))}};
}

void write_map(const std::string& dir, const StabilityMap& map) {
  write_file_whole(dir + '/' + map.name + ".csv", points_csv(map));
  write_file_whole(dir + '/' + map.name + "_boundaries.csv", boundaries_csv(map));
}

}  // namespace kt
