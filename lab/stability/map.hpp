#pragma once
// A stability map as data: where a method works, degrades or fails, and what was predicted before each run.
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace kt {

/// works: as it should. degrades: runs on, but wrong by what a person notices (force off by more than the JND of 10 %,
/// buzz). fails: non-finite, energy grows, limit cycle, contact lost, no result.
enum class MapVerdict { works, degrades, fails };

/// One run.
struct MapPoint {
  std::string series;  ///< a method, a body: what has a boundary of its own
  double x = 0, y = 0;
  MapVerdict verdict = MapVerdict::works;
  std::string why;                 ///< of the verdict, in words with numbers
  double value = 0;                ///< what the verdict was taken from; each map says what it is
  bool predicted_failure = false;  ///< by the engine, before the run (haptics/predict/predict.hpp)
  std::string prediction;          ///< its message
  std::uint64_t hash = 0;          ///< of the run's result: equal on every run of the command
};

/// A line through the map: measured by bisection, or from theory.
struct MapBoundary {
  std::string series;
  std::string label;
  std::vector<std::pair<double, double>> points;  ///< (x, y); a NaN breaks the line
  bool theory = false;
};

struct StabilityMap {
  std::string name, title;     ///< filled in from the table
  std::string x_name, y_name;  ///< with units
  bool x_log = false, y_log = false;
  std::vector<MapPoint> points;
  std::vector<MapBoundary> boundaries;
  std::string claim;   ///< what the map shows, one sentence with measured numbers
  double seconds = 0;  ///< wall clock, filled in by the command
};

struct MapOptions {
  bool full = false;                          ///< finer, and larger bodies
  std::function<void(double)> progress = {};  ///< share done, 0..1
  const std::atomic<bool>* stop = nullptr;    ///< Ctrl-C: end soon and keep what is there
  int jobs = 2;                               ///< threads
};

inline bool is_stopped(const MapOptions& options) { return options.stop && options.stop->load(); }

inline const char* word(MapVerdict verdict) {
  return verdict == MapVerdict::works ? "works" : verdict == MapVerdict::degrades ? "degrades" : "fails";
}

/// Predicted against observed. A point that degrades counts as neither failure nor false alarm.
struct Confusion {
  int points = 0;
  int failures = 0, predicted = 0;  ///< points that fail; of these, those that were predicted
  int degraded = 0, degraded_warned = 0;
  int working = 0, false_alarms = 0;  ///< points that work; of these, those predicted to fail
  int alarms() const { return predicted + degraded_warned + false_alarms; }
  void add(const Confusion& c);
  bool operator==(const Confusion&) const = default;
};

Confusion count_predictions(const std::vector<MapPoint>& points);

}  // namespace kt
