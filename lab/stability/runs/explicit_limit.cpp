#include "lab/stability/runs/explicit_limit.hpp"

#include <cmath>
#include <limits>

#include "haptics/predict/predict_time_step.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/step_runs.hpp"

namespace kt {

RayResult find_explicit_limit(const DeformableModel& model, const std::string& integrator, const std::string& series,
                              double x) {
  // From a small shake: the fastest mode starts with a few per cent of it. Below the limit undamped motion is a long
  // ellipse, ten times as long as wide at half a per cent from it; above, it grows by a per cent a step or more.
  constexpr double kGrowth = 1e3, kShake = 1e-8;  // of the start; of the body's size
  constexpr int kSteps = 2000;
  const FastestMode mode = fastest_mode(model, rest_state(model));
  State start = rest_state(model);
  start.x += shaken_positions(model, kShake * bounds(model.mesh()).size().maxCoeff());
  RayResult out;
  const auto fails = [&](double dt) {
    MapPoint p = point_at(series, x, dt, predict_unstable_step(mode, integrator, dt));
    const auto stepper = make_integrator(integrator);
    const StepRun run = run_steps(model, *stepper, start, dt, kSteps, kGrowth);
    judge_growth(run, kGrowth, p);
    out.points.push_back(p);
    return p.verdict == MapVerdict::fails;
  };
  const RayCrossing limit = bisect(1e-6, 1, {.tolerance = 0.005}, fails);
  out.boundaries.push_back({series, kMeasuredLimit, {{x, limit.at()}}, false});
  out.boundaries.push_back(
      {series, "theory: 2/(ω_max(√(1+ζ²)+ζ)), Lanczos", {{x, make_integrator(integrator)->stable_step(mode)}}, true});
  return out;
}

double distance_from_theory(const StabilityMap& map, const std::function<bool(const std::string&)>& holds) {
  double out = std::numeric_limits<double>::quiet_NaN();
  for (const MapBoundary& measured : map.boundaries)
    for (const MapBoundary& theory : map.boundaries) {
      if (measured.theory || !theory.theory || measured.series != theory.series || !holds(measured.series)) continue;
      for (std::size_t i = 0; i < std::min(measured.points.size(), theory.points.size()); ++i)
        out = std::fmax(out, std::abs(measured.points[i].second / theory.points[i].second - 1));
    }
  return out;
}

}  // namespace kt
