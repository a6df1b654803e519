#pragma once
// The local models that "auto" chooses from: what each is, costs and is off by, and which one to take.
#include <optional>
#include <string>
#include <vector>

#include "core/local/certified_rates.hpp"
#include "core/local/reducer.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/excitation.hpp"

namespace kt {

/// A way to make local models, and what was found out about it at set-up.
struct ReducerCandidate {
  std::string reducer;
  ReduceOptions options;
  std::string name;  ///< "krylov {0, 200} Hz"
  int dof = 0;
  double error = 0;              ///< certified, worst of 0-500 Hz, relative; infinity: it could not be made
  std::vector<double> errors{};  ///< certified, at kCertifiedHz; NaN: not known there; empty: at none
  double force_error = 0;        ///< to expect: `errors` weighted by what is excited; without a motion: `error`
  double tick_us = 0;            ///< predicted, in contact (tick_cost.hpp)
  double own_ms = 0;             ///< predicted CPU time of making the local model
  double refresh_ms = 0;         ///< predicted: the whole refresh, with its global step
  double cost_us = 0;  ///< predicted CPU time of both sides a haptic tick, without contact, which costs all alike
};

struct ReducerNeeds {
  double tolerance = 0.05;         ///< largest error of the force to expect, that of the local model: model_tolerance()
  double budget_us = 200;          ///< of a haptic tick
  double refresh_per_tick = 0.03;  ///< global rate over haptic rate
  bool whole = false;              ///< no node follows others: they may be those of a piece that only touches its own
  double refresh_budget_ms = std::numeric_limits<double>::infinity();
  double rest_ms = 0;                  ///< predicted: what a refresh takes before and after the local model
  double beside_ms = 0;                ///< predicted: what another core takes meanwhile, for refined cells
  std::optional<BandPowers> motion{};  ///< that the surface follows, as far as it is known at set-up
  double cells_error = 0;              ///< of the force, of refined cells under the tool; 0: none are refined
};

/// Largest error of a local model for which the whole force keeps to a tolerance. The errors of cells and local model
/// are independent and add up as squares. Where the cells alone are off by about the tolerance or more, the whole may
/// be off by a quarter more than they are: a better local model would cost more, and the force would hardly gain.
/// @param cells_error  of the force, of the cells under the tool
double model_tolerance(double tolerance, double cells_error);

/// What local.reducer takes: core/local/reducers.def, and "auto".
std::vector<BackendInfo> reducer_names();

/// One, by its name in core/local/reducers.def.
ReducerCandidate make_reducer_candidate(const std::string& reducer, int rings);
/// Those of "auto".
std::vector<ReducerCandidate> auto_candidates(int num_nodes);

/// Refreshes that it takes in the time of one: a model that is too stiff at rest is off at the end of each interval, so
/// that the next one is asked for early (44 to 65 instead of 23 to 28 in five drags).
double refreshes_per_interval(const ReducerCandidate& candidate);

/// Of the most accurate of them [Hz].
const std::vector<double>& most_shifts_hz();

/// Index of the cheapest that needs no more than the tolerance and both budgets, or of the most accurate that costs no
/// more than a tenth more; else, of those within the budgets, the
/// one with the least error (the budgets win); else the most accurate of those that are over them by hardly more than
/// need be. Candidates are not empty.
std::size_t choose_reducer(const std::vector<ReducerCandidate>& candidates, const ReducerNeeds& needs);

/// CPU time of making a local model [us], from the sizes alone, so that the same scene chooses the same everywhere:
/// right to within a factor of two.
double predict_refresh_us(const LocalModel& model, const ReduceOptions& options);
/// The same of what a refresh takes beside that [ms]: global step, look-ahead, tangent.
double predict_rest_ms(int num_nodes, int num_tetrahedra, bool is_fem);

}  // namespace kt
