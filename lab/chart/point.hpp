#pragma once
// One method on one body, measured: what is drawn as a point.
#include <nlohmann/json.hpp>
#include <span>

namespace kt {

/// Errors and costs that a chart can have on its axes: key in the summary of a run, name and unit for readers.
struct ChartAxis {
  const char* key;      ///< column of chart.csv
  const char* summary;  ///< JSON pointer into summary.json
  const char* title;    ///< with its unit
  double scale;         ///< from the summary's unit to the title's
  bool is_cost;
};
std::span<const ChartAxis> chart_axes();

/// The row of a batch (io/files/json_batch.hpp) as a point: outcome, trouble, hash, dof, whether cells were refined,
/// and every axis, null where the run has none.
nlohmann::ordered_json chart_point(const nlohmann::ordered_json& row);

/// Which points no other one beats in both: as cheap and more exact, or as exact and cheaper. Those that are not finite
/// never are. O(n log n).
std::vector<bool> pareto_front(std::span<const double> cost, std::span<const double> error);

}  // namespace kt
