#pragma once
// Many steps of one integrator on one body, without contact: does what it started with grow, and how wrong is a period?
#include <cstdint>
#include <string>

#include "core/base/error.hpp"
#include "core/body/state.hpp"
#include "core/global/integrator.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/bodies.hpp"

namespace kt {

struct StepRun {
  double growth = 0;        ///< largest displacement / the first one; infinity when not finite
  double period_error = 0;  ///< of a vibration, after one of its periods, relative [-]
  int steps = 0;            ///< that were made
  bool converged = true;    ///< every step of Newton's method
  std::string error;        ///< of a step that threw
  std::uint64_t hash = 0;
  bool diverged(double limit) const { return !(growth <= limit) || !error.empty(); }
};

/// Steps from `start` until the displacement from rest exceeds `limit` times the first one, or `steps` are done.
StepRun run_steps(const DeformableModel& model, Integrator& integrator, State start, double dt, int steps,
                  double limit);

/// What such a run says of a point of a map: it fails when the displacement grew by more than `limit`.
void judge_growth(const StepRun& run, double limit, MapPoint& point);

/// Judges a point by `work`, steps of `state`: one that throws RunError has failed.
template <class Work>
void judge_steps(MapPoint& point, const State& state, const Work& work) {
  try {
    work();
  } catch (const RunError& e) {
    point.verdict = MapVerdict::fails;
    point.why = e.what();
  }
  StateHash hash;
  hash.add(state.x);
  point.hash = hash.value();
}

/// Steps of the vibration, released at rest. With q its amplitude and p that of its velocity over omega, q + ip turns
/// and shrinks by the same factor in every step; the error is that factor taken for a whole
/// period, minus one (for a step, when that is longer than the period, minus the exact factor).
StepRun run_vibration(const DeformableModel& model, Integrator& integrator, const Vibration& vibration,
                      double amplitude, double dt, int steps);

/// The same from theory: |R(-i w h)^(2 pi / (w h)) - 1| with R the integrator's stability function. NaN: unknown.
double theoretical_period_error(const std::string& integrator, double omega_h);

}  // namespace kt
