#pragma once
// Which model, mesh, global rate and reducer is the cheapest that stays within a tolerance, measured on a scene itself.
// Two errors add up: what model and mesh are off from the continuum (a press at rest against a much finer body), and
// what the two rates add on that body (a drag against run_reference).                                 docs/advise.md
#include <atomic>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"
#include "io/scene/scene.hpp"

namespace kt {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

enum class Limit { none, error, slow_load, tick_load };

/// What a choice is made from. Unknown error or cost (NaN): it cannot be chosen.
struct Candidate {
  double error = kUnknown;  ///< of the force, relative
  double cost = kUnknown;   ///< what is to be small
  double slow_load = 0;     ///< time of the slow side / its interval
  double tick_load = 0;     ///< time of a haptic tick / its period
};

inline bool is_real_time(const Candidate& c) { return c.slow_load <= 1 && c.tick_load <= 1; }

struct Choice {
  int index = -1;  ///< the cheapest within all limits; where there is none, the nearest to them, in real time if any
                   ///< is; -1: none known
  Limit missed = Limit::none;  ///< by the nearest: the limit that it misses by most
  bool found() const { return index >= 0 && missed == Limit::none; }
};

/// The limit that a candidate misses by most, and its value over what is allowed; at most 1 when it is within all.
std::pair<Limit, double> worst_limit(const Candidate& candidate, double tolerance);

/// Equal costs: the smaller error; then the earlier.
Choice choose(std::span<const Candidate> candidates, double tolerance);

/// A model on a mesh.
struct AdviceBody {
  std::string model = "msd";        ///< msd, tet4, tet10
  std::string mesh_name = "own";    ///< in words
  SceneTetrahedralize filled = {};  ///< what makes that mesh
  bool refined = false;             ///< cells under the tool (local.refine)
  Mesh mesh = {};
  int nodes = 0;
  double force = kUnknown;                     ///< on the pressed tool [N]
  double error = kUnknown;                     ///< of that force
  double cell_over_contact_radius = kUnknown;  ///< under the tool
  double expected_factor = kUnknown;           ///< of the continuum's force, by contact_width.hpp
  double refresh_ms = kUnknown;                ///< CPU time of a global step and the cheapest local model from it
  std::string note = {};                       ///< why it was not judged
  double reference_rate_hz = 0, reference_seconds = 0;  ///< of its full model: steps, how much of the path; 0: not run
};

/// A global rate and a reducer on a body.
struct AdviceRow {
  int body = 0;  ///< of Advice::bodies
  double rate_hz = 0;
  std::string reducer;
  double rates_error = kUnknown;    ///< of the force along the path, against the full model of the same body
  double error = kUnknown;          ///< with the body's own
  double global_ms = 0;             ///< a step of the body, p50
  double refresh_ms = 0;            ///< and a local model from it, p50
  double tick_us = 0;               ///< CPU time of a haptic tick, p99
  double core_share = kUnknown;     ///< CPU time of both sides together, of one core
  double refreshes_per_second = 0;  ///< that there were: early ones come on top of the rate
  std::string note = {};            ///< why it was not judged
};

/// What bodies are judged by.
struct AdviceTruth {
  std::string why_none;  ///< why bodies cannot be judged; empty: they can
  double depth = 0;      ///< of the press [m]
  int nodes = 0;
  double force = kUnknown;        ///< [N]
  double uncertainty = kUnknown;  ///< its change from the next coarser one, relative
};

struct Advice {
  double tolerance = 0;
  AdviceTruth truth;
  std::vector<AdviceBody> bodies;
  std::vector<AdviceRow> rows;
  Choice row;
  std::vector<std::string> settings;  ///< key=value, for --set; empty when nothing was chosen
  double seconds = 0;                 ///< that it took
  bool stopped = false;

  /// A row is within the limits, on a body that is within them or cannot be judged.
  bool found() const { return row.found(); }
};

struct AdviseOptions {
  double tolerance = 0.05;                    ///< of the force, relative, > 0
  double budget_seconds = 120;                ///< wall clock; what does not fit is left out, and its row says so
  std::function<void(double)> progress = {};  ///< share of the budget, 0..1
  const std::atomic<bool>* stop = nullptr;    ///< end soon, with what is there
};

/// Throws InputError for a scene that cannot be judged, RunError when not even its own body can be run.
Advice advise(const Scene& scene, const AdviseOptions& options = {});

Candidate candidate_of(const AdviceBody& body);
Candidate candidate_of(const AdviceRow& row, double local_rate_hz);

}  // namespace kt
