// Stiffness of a virtual wall x damping of the device, for several rates and delays: where a hand on a haptic device
// feels a limit cycle, and how far passivity control moves that. On top: b = K (T/2 + T_d), the line of passivity.
// Colgate and Schenkel 1997, Diolaiti et al. 2006.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/predict/predict_hand.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/wall_loop.hpp"

namespace kt {
namespace {

constexpr double kMostDamping = 20;  // [N s/m] of passivity control: a fifth of what stops 0.1 kg within a tick
constexpr double kStiffest = 1e5;    // [N/m] beyond any device's
constexpr double kSoftest = 1;

struct Setting {
  const char* name;
  double rate_hz, delay;
};
constexpr Setting kSettings[] = {{"4 kHz", 4000, 0},
                                 {"1 kHz", 1000, 0},
                                 {"250 Hz", 250, 0},
                                 {"1 kHz, 2 ms late", 1000, 2e-3},
                                 {"1 kHz, 5 ms late", 1000, 5e-3}};

const char* const kWall = "wall";
const char* const kControlled = "wall, passivity control";

HandLoop loop_of(const Setting& setting, double damping) {
  HandLoop out;
  out.h = 1 / setting.rate_hz;
  out.delay = setting.delay;
  out.hand_damping = damping;
  return out;
}

RayResult wall_ray(const Setting& setting, double damping, bool controlled, const MapOptions& options) {
  const std::string series = text(setting.name, " | ", controlled ? kControlled : kWall);
  RayResult out;
  HandLoop loop = loop_of(setting, damping);
  const auto fails = [&](double stiffness) {
    loop.wall_stiffness = stiffness;
    const double most = controlled ? kMostDamping : 0;
    MapPoint p = point_at(series, damping, stiffness, predict_limit_cycle(loop, most));
    const WallRun run = press_wall(loop, most);
    p.verdict = judge_ripple(run, p.why);
    p.value = run.ripple;
    p.hash = run.hash;
    out.points.push_back(p);
    return p.verdict == MapVerdict::fails;
  };
  for (double k = kSoftest; k <= kStiffest; k *= options.full ? 2 : 10) fails(k);
  // The first stiffness that fails, from below.
  double good = 0, bad = 0;
  for (const MapPoint& p : out.points) {
    if (p.verdict == MapVerdict::fails) {
      bad = p.y;
      break;
    }
    good = p.y;
  }
  if (good > 0 && bad > 0) {
    const RayCrossing limit = bisect(good, bad, {.tolerance = 0.05}, fails);
    out.boundaries.push_back({series, "limit cycle, measured", {{damping, limit.at()}}, false});
  }
  const double passive = damping / (0.5 * loop.h + loop.delay);
  out.boundaries.push_back({series, "theory: b = K (T/2 + T_d), passive below", {{damping, passive}}, true});
  return out;
}

/// Measured limit / the line of passivity, over the settings with that column.
std::vector<double> ratios(const StabilityMap& map, const std::string& column) {
  std::vector<double> out;
  for (const MapBoundary& measured : map.boundaries)
    for (const MapBoundary& line : map.boundaries) {
      if (measured.theory || !line.theory || measured.series != line.series) continue;
      if (!measured.series.ends_with("| " + column)) continue;
      for (const auto& [x, y] : measured.points)
        for (const auto& [line_x, line_y] : line.points)
          if (x == line_x) out.push_back(y / line_y);
    }
  return out;
}

double lowest_ratio(const StabilityMap& map, const std::string& column) {
  const std::vector<double> all = ratios(map, column);
  return all.empty() ? 0 : std::ranges::min(all);
}

double highest_ratio(const StabilityMap& map, const std::string& column) {
  const std::vector<double> all = ratios(map, column);
  return all.empty() ? 0 : std::ranges::max(all);
}

}  // namespace

StabilityMap map_hand(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "damping of hand and device b [N s/m]";
  map.y_name = "stiffness K [N/m]";
  map.x_log = map.y_log = true;
  const std::vector<double> dampings =
      options.full ? std::vector<double>{0.2, 0.5, 1, 2, 5, 10, 20} : std::vector<double>{0.3, 1, 3, 10};
  struct Ray {
    Setting setting;
    double damping;
    bool controlled;
  };
  std::vector<Ray> rays;
  for (const Setting& s : kSettings)
    for (bool controlled : {false, true})
      for (double b : dampings) rays.push_back({s, b, controlled});
  run_rays(
      options, static_cast<int>(rays.size()),
      [&](int i) { return wall_ray(rays[i].setting, rays[i].damping, rays[i].controlled, options); }, map);
  map.claim = told("without control a wall is stable up to ", lowest_ratio(map, kWall), " to ",
                   highest_ratio(map, kWall), " times the line of passivity; passivity control with up to ",
                   kMostDamping, " N s/m raises that at least ", lowest_ratio(map, kControlled), " times");
  return map;
}

}  // namespace kt
