// A hand on a device of which nobody knows how it damps, and whose delay is told wrong or measured: which of passivity
// control, virtual coupling and energy bounding holds how stiff a wall. haptics/device/{passivity,device_coupling,
// measured_delay}.hpp.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/predict/predict_hand.hpp"
#include "haptics/safety/device_coupling.hpp"
#include "haptics/safety/measured_delay.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/wall_loop.hpp"

namespace kt {
namespace {

constexpr double kTick = 1e-3;
constexpr double kAdds = 20;  // [N s/m] of passivity control
constexpr double kSoftestWall = 10, kStiffestWall = 1e5;

enum class Between { nothing, control, coupling, known_coupling, both, both_adapting, bounding };

struct Column {
  Between what;
  const char* name;
};
constexpr Column kColumns[] = {{Between::nothing, "none"},
                               {Between::control, "passivity control"},
                               {Between::coupling, "coupling 1 kN/m"},
                               {Between::known_coupling, "coupling, b known"},
                               {Between::both, "control + coupling 1 kN/m"},
                               {Between::both_adapting, "the same, adapting"},
                               {Between::bounding, "energy bounding, b known"}};

struct Delays {
  const char* name;
  double is, told;  // [s]
};

/// What MeasuredDelay makes of a device that acknowledges after so long.
double measured(double delay) {
  MeasuredDelay out(kTick);
  for (int i = 0; i < MeasuredDelay::kEnough; ++i) out.add(delay);
  return out.estimate().delay;
}

std::vector<Delays> delays() {
  return {{"0 ms, told 0", 0, 0},
          {"0 ms, told 1", 0, 1e-3},
          {"0 ms, measured", 0, measured(0)},
          {"0.8 ms, told 0", 0.8e-3, 0},
          {"0.8 ms, told half", 0.8e-3, 0.4e-3},
          {"0.8 ms, told 1 more", 0.8e-3, 1.8e-3},
          {"0.8 ms, measured", 0.8e-3, measured(0.8e-3)},
          {"3 ms, told 0", 3e-3, 0},
          {"3 ms, told half", 3e-3, 1.5e-3},
          {"3 ms, told 1 more", 3e-3, 4e-3},
          {"3 ms, measured", 3e-3, measured(3e-3)}};
}

HandPort port_of(Between what, double damping, double told) {
  HandPort out;
  out.delay = told;
  const bool controls = what == Between::control || what == Between::both || what == Between::both_adapting;
  if (controls) out.most_damping = kAdds;
  if (what == Between::coupling || what == Between::both || what == Between::both_adapting)
    out.coupling = coupling_stiffness(0, 0, kTick, told);
  if (what == Between::known_coupling) out.coupling = coupling_stiffness(damping, 0, kTick, told);
  if (what == Between::bounding) out.bounded_damping = damping;
  out.adapts = what == Between::both_adapting;
  return out;
}

RayResult ray(const Delays& delay, const Column& column, double damping, const MapOptions& options) {
  RayResult out;
  const std::string series = text(delay.name, " | ", column.name);
  HandLoop loop;
  loop.h = kTick;
  loop.delay = delay.is;
  loop.hand_damping = damping;
  const HandPort port = port_of(column.what, damping, delay.told);
  const auto fails = [&](double stiffness) {
    loop.wall_stiffness = stiffness;
    MapPoint p = point_at(series, damping, stiffness, predict_limit_cycle(loop, port));
    const WallRun run = press_wall(loop, port);
    p.verdict = judge_ripple(run, p.why);
    p.why += told("; felt as ", run.felt, " N/m");
    p.value = run.felt;
    p.hash = run.hash;
    out.points.push_back(p);
    return p.verdict == MapVerdict::fails;
  };
  // The first stiffness that fails, from below.
  double good = 0, bad = 0;
  for (double k = kSoftestWall; k <= kStiffestWall && !(bad > 0); k *= options.full ? 2 : std::sqrt(10))
    (fails(k) ? bad : good) = k;
  double limit = bad > 0 ? kSoftestWall : kStiffestWall;  // of the whole ray
  if (good > 0 && bad > 0) limit = bisect(good, bad, {.tolerance = 0.1}, fails).at();
  out.boundaries.push_back({series, "largest wall without swing", {{damping, limit}}, false});
  out.boundaries.push_back(
      {series, "theory: b = K (T/2 + T_d)", {{damping, damping / (0.5 * kTick + delay.is)}}, true});
  return out;
}

/// Smallest limit over all dampings of the series that end so, and what the least device holds with nothing between.
double least(const StabilityMap& map, const std::string& end) {
  double out = kStiffestWall;
  for (const MapBoundary& b : map.boundaries)
    if (!b.theory && b.series.ends_with(end))
      for (const auto& [x, y] : b.points) out = std::min(out, y);
  return out;
}

}  // namespace

StabilityMap map_unknown_hand(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "damping of hand and device b [N s/m]";
  map.y_name = "stiffness K [N/m]";
  map.x_log = map.y_log = true;
  const std::vector<double> dampings =
      options.full ? std::vector<double>{0.1, 0.2, 0.3, 0.5, 1, 2, 3} : std::vector<double>{0.1, 0.3, 1, 3};
  struct Ray {
    Delays delay;
    Column column;
    double damping;
  };
  std::vector<Ray> rays;
  for (const Delays& delay : delays())
    for (const Column& column : kColumns)
      for (double b : dampings) rays.push_back({delay, column, b});
  run_rays(
      options, static_cast<int>(rays.size()),
      [&](int i) { return ray(rays[i].delay, rays[i].column, rays[i].damping, options); }, map);
  map.claim = told("with the delay measured, over all dampings and delays: without anything a wall of ",
                   least(map, "measured | none"), " N/m is held, with passivity control ",
                   least(map, "measured | passivity control"), ", with the coupling alone ",
                   least(map, "measured | coupling 1 kN/m"), ", with both ",
                   least(map, "measured | control + coupling 1 kN/m"));
  return map;
}

}  // namespace kt
