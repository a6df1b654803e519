#pragma once
// What every run of a check is asked, whatever its path.
#include "apps/check/mesh_work.hpp"
#include "haptics/metrics.hpp"
#include "haptics/reference.hpp"

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

/// Forces of the whole nonlinear body along the first `ticks` of a run, in steps of 2 kHz; nothing for a body that is
/// too large for that, or that leaves the finite numbers.
std::optional<Reference> truth_of(const CheckBody& body, const SessionResult& run, std::size_t ticks,
                                  const std::atomic<bool>* stop);

/// Of a tool that had no contact for so many ticks in a row.
/// @param whole_body  for how many the whole nonlinear body leaves the tool along the same way; none: not known
Verdict judge_loss(int ticks, std::optional<int> whole_body);

/// Numbers that no run may have: forces that are not finite, a tool inside the body, energy out of nothing.
void judge_run(const SessionResult& run, const std::string& name, const Vec3& where, RunExtremes& all,
               StageResult& out);

void report_runs(const RunExtremes& all, const std::string& model, StageResult& out);

}  // namespace kt
