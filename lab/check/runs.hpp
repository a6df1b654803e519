#pragma once
// What every run of a check is asked, whatever its path.
#include "haptics/session/metrics.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/study/reference.hpp"

namespace kt {

/// Figures of many runs: the worst of each.
struct RunExtremes {
  int runs = 0, ticks = 0, lost = 0, missed = 0;
  int inverted = 0;            ///< most tetrahedra inside out at a time; springs come back from it, mostly
  double penetration = 0;      ///< deepest [m]
  double certified_error = 0;  ///< largest
  double energy_min = 0;       ///< [J] least work of the tool at any time of any run
  std::vector<double> step_us, refresh_ms, global_ms;
};

/// The body from its start on, with the tool along a path. Each run chooses its own local model and revises it, as
/// `kilotouch run` does, though that takes half of a check's time: one of another place can throw the body away.
SessionResult run_along(CheckBody& body, std::vector<TimedPoint> path, const std::atomic<bool>* stop);

/// Forces of the whole nonlinear body along the first `ticks` of a run, in steps of 2 kHz, or of 4, 8 or 16 where these
/// leave the finite numbers; nothing for a body that is too large for that.
std::optional<Reference> truth_of(const CheckBody& body, const SessionResult& run, std::size_t ticks,
                                  const std::atomic<bool>* stop);

/// Most ticks in a row in which a tool had no contact.
struct Loss {
  int ticks = 0;
  std::optional<int> whole_body;  ///< for how many the whole nonlinear body leaves it along the same way; none: unknown

  std::string told() const;
};

/// Between two times of a run [s]; the whole body is asked only where there are any.
Loss longest_loss(const CheckBody& body, const SessionResult& run, double from, double to,
                  const std::atomic<bool>* stop);

Verdict judge_loss(const Loss& loss);

/// Of the forces at rest of one press, from each depth to the next: the one that falls most.
struct Fall {
  double share = 0;    ///< of the largest force; 0: none falls
  std::size_t to = 0;  ///< which depth it leads to
};

/// @param force  at each depth [N], at least one
Fall largest_fall(std::span<const double> force);

/// A limb that gives way, or a tool that slips off, pushes back less the deeper it is: no fault of the engine where the
/// whole nonlinear body's force falls at least half as much, but no surface to press either.
/// @param of_whole_body  along the same way; none: unknown
Verdict judge_fall(const Fall& fall, const std::optional<Fall>& of_whole_body);

/// Numbers that no run may have: forces that are not finite, a tool inside the body, energy out of nothing.
void judge_run(const SessionResult& run, const std::string& name, const Vec3& where, RunExtremes& all,
               StageResult& out);

void report_runs(const RunExtremes& all, const std::string& model, StageResult& out);

}  // namespace kt
