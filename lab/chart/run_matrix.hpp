#pragma once
// Runs matrices of methods and bodies, each as a `kilotouch run` of its own, and gathers what a chart shows.
#include <atomic>
#include <functional>
#include <nlohmann/json.hpp>

#include "lab/chart/matrix.hpp"

namespace kt {

struct ChartSettings {
  std::string out;  ///< folder
  int jobs = 1;     ///< runs side by side
  bool resume = false;
  double seconds = 600;       ///< limit of one run
  double reference_hz = 2e4;  ///< steps of the full model; half as fine ones show how far it has converged
  const std::atomic<bool>* stop = nullptr;
  std::function<void(double)> progress = {};  ///< share done, 0..1
};

/// All of them as one batch, whose rows are in runs.jsonl in the folder. An array, for each matrix: name, title, scene,
/// and
///   references: per body, force changed by halving the step (same-mesh truth), or what the truth is
///   points: body, family, label, is_ours, command, then chart_point(), and pareto: in front by force error and median
///   tick
nlohmann::ordered_json run_matrices(const std::vector<ChartMatrix>& matrices, const ChartSettings& settings);

}  // namespace kt
