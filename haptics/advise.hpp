#pragma once
// Which model, mesh, global rate and reducer is the cheapest that stays within a tolerance, measured on a scene itself.
// Two questions, one after the other: what model and mesh are off from the continuum (a static press against a finer
// body), then what the two rates add on the model and mesh of choice (a drag against run_reference).    docs/advise.md
#include <atomic>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/scene.hpp"

namespace kt {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// What a choice is made from. Of a limit that plays no part the value is 0; unknown values are NaN.
struct Candidate {
  double error = kUnknown;  ///< of the force, relative
  double cost = kUnknown;   ///< what is to be small
  double slow_load = 0;     ///< time of the slow side / its interval
  double tick_load = 0;     ///< time of a haptic tick / its period
  bool measured = false;
};

enum class Limit { none, error, slow_load, tick_load };

struct Choice {
  int index = -1;  ///< the cheapest within all limits; where there is none, the nearest to them; -1: none measured
  Limit missed = Limit::none;  ///< by the nearest: the limit that it misses by most
  double by = 0;               ///< its value over what is allowed, above 1
  bool found() const { return index >= 0 && missed == Limit::none; }
};

/// The limit that a candidate misses by most, and its value over what is allowed; at most 1 when it is within all.
std::pair<Limit, double> worst_limit(const Candidate& candidate, double tolerance);

/// Equal costs: the smaller error; then the earlier.
Choice choose(std::span<const Candidate> candidates, double tolerance);

/// A model on a mesh.
struct AdviceBody {
  std::string model;                      ///< msd, tet4, tet10
  std::optional<double> max_volume = {};  ///< [m^3]; absent: the scene's own mesh
  int nodes = 0, tetrahedra = 0;
  double force = kUnknown;      ///< of the pressed tool [N]
  double error = kUnknown;      ///< of that force
  double global_ms = kUnknown;  ///< a step of the body on one core
  std::string note = {};        ///< why it was not measured, what went wrong
  bool measured = false;
};

/// What the two rates add, on the chosen body.
struct AdviceRow {
  double rate_hz = 0;
  std::string reducer;
  double error = kUnknown;               ///< of the force over the path, against the reference
  double jnd_fraction = kUnknown;        ///< see ForceError
  double global_ms = 0, refresh_ms = 0;  ///< p50, on one core
  double step_us_p50 = 0, step_us_p99 = 0;
  double refreshes_per_second = 0;  ///< that there were: early ones come on top of the rate
  double core_share = kUnknown;     ///< CPU of both sides together, of one core
  int dof = 0;
  std::string note = {};
  bool measured = false;
};

struct AdviceTruth {
  std::string what;  ///< in words; empty: there is none
  int nodes = 0, tetrahedra = 0;
  double force = kUnknown;        ///< [N]
  double uncertainty = kUnknown;  ///< its change from a coarser one, relative
  double edge = 0;                ///< of its surface at the contact [m]; 0: the scene's own
};

struct AdviceReference {
  double rate_hz = 0, seconds = 0;  ///< of its steps; how much of the path it covers
  double cpu_seconds = 0;
  std::string note;
};

struct Advice {
  double tolerance = 0;
  AdviceTruth truth;
  std::vector<AdviceBody> bodies;
  Choice body;  ///< of bodies
  AdviceReference reference;
  std::vector<AdviceRow> rows;
  Choice row;                         ///< of rows
  std::vector<std::string> notes;     ///< what the answer leaves out and why
  std::vector<std::string> settings;  ///< key=value, to paste after --set; empty when nothing was chosen
  std::string reason;                 ///< one sentence
  double seconds = 0;                 ///< that it took
  bool stopped = false;
  bool found() const { return row.found() && body.index >= 0 && body.missed == Limit::none; }
};

struct AdviseOptions {
  double tolerance = 0.05;                  ///< of each of the two errors, > 0
  double budget_seconds = 120;              ///< wall clock; what does not fit is left out, and the answer says so
  std::function<void(double)> progress;     ///< share of the budget, 0..1
  const std::atomic<bool>* stop = nullptr;  ///< end soon, with what is there
};

/// Throws InputError for a scene that cannot be judged, RunError when not even its own body can be run.
Advice advise(const Scene& scene, const AdviseOptions& options = {});

Candidate candidate_of(const AdviceBody& body);
Candidate candidate_of(const AdviceRow& row, double local_rate_hz);

}  // namespace kt
