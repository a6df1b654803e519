#include "lab/stability/runs/wall_loop.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/numbers.hpp"
#include "core/body/state.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/safety/device_coupling.hpp"
#include "haptics/safety/passivity.hpp"
#include "lab/stability/runs/energy_bounding.hpp"

namespace kt {
namespace {

constexpr double kDepth = 0.005;   // [m] of the target behind the wall
constexpr double kApproach = 0.1;  // [s]

/// Long enough for the hand's own damping to take all but e^-12 of a swing.
double duration(const HandLoop& loop) {
  return std::clamp(12 * 2 * loop.mass / std::max(loop.hand_damping, 1e-9), 1.0, 10.0);
}

}  // namespace

Swing swing_of(std::span<const double> values, double from, double to) {
  const auto n = static_cast<double>(values.size());
  const auto part = values.subspan(static_cast<std::size_t>(from * n), static_cast<std::size_t>((to - from) * n));
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
  for (double v : part) {
    low = std::min(low, v);
    high = std::max(high, v);
    sum += std::abs(v);
  }
  return {high - low, sum / static_cast<double>(part.size())};
}

MapVerdict judge_ripple(const WallRun& run, std::string& why) {
  constexpr double kJnd = 0.1;
  constexpr double kDiesOut = 0.97;  // of the ripple a quarter of the run before
  constexpr double kBounces = 0.8;   // the same of a tool that lifts off: its swing does not follow the linear loop
  constexpr double kEncoderSwing = 5e-5;  // [m] five steps of the encoder: less is its noise
  why = told("force swings by ", in_percent(run.ripple), " of its mean at the end, by ", in_percent(run.ripple_before),
             " before; the tool by ", in_unit(run.swing, "m"));
  if (!(run.ripple > kJnd)) return MapVerdict::works;
  const bool bounces = run.ripple > 1;
  if (run.swing > kEncoderSwing && run.ripple > (bounces ? kBounces : kDiesOut) * run.ripple_before) {
    why = "limit cycle: " + why;
    return MapVerdict::fails;
  }
  return MapVerdict::degrades;
}

WallRun press_wall(const HandLoop& loop, double most_damping) {
  return press_wall(loop, HandPort{.most_damping = most_damping, .delay = loop.delay});
}

WallRun press_wall(const HandLoop& loop, const HandPort& port) {
  DeviceOptions options;
  options.path = {{0, {0, 0, kDepth}}, {kApproach, {0, 0, -kDepth}}};
  options.h = loop.h;
  options.hand_mass = loop.mass;
  options.hand_stiffness = loop.hand_stiffness;
  options.hand_damping = loop.hand_damping;
  options.hand_delay = loop.delay;
  const auto device = make_device("hand", options);
  PassivityControl passivity({port.most_damping, loop.h, port.delay, device->info().max_force});
  DeviceCoupling coupling({.stiffness = port.coupling, .adapts = port.adapts});
  EnergyBounding bounding(kCouplingShare * port.bounded_damping, loop.h, port.delay);
  const auto ticks = static_cast<int>(std::lround(duration(loop) / loop.h));
  std::vector<double> forces, places;
  WallRun out;
  StateHash hash;
  double before = 0;
  for (int i = 0; i < ticks; ++i) {
    const Vec3 x = device->pose((i + 1) * loop.h).x;
    const double z = coupling.tool(x, loop.h).z();
    const double rate = i > 0 ? (z - before) / loop.h : 0;
    before = z;
    // It pushes only: a wall does not stick.
    const double wall = z < 0 ? std::max(0.0, -loop.wall_stiffness * z - loop.wall_damping * rate) : 0;
    Vec3 force = coupling.force({0, 0, wall});
    if (port.bounded_damping > 0) force = bounding.tick(x, force);
    const Vec3 shown = passivity.tick(x, force);
    device->write({.force = shown}, loop.h);
    forces.push_back(shown.z());
    places.push_back(x.z());
    hash.add(shown.z());
  }
  out.ripple = swing_of(forces, 0.75, 1).ripple();
  out.ripple_before = swing_of(forces, 0.5, 0.75).ripple();
  const Swing depth = swing_of(places, 0.75, 1);
  out.swing = depth.size;
  out.felt = depth.mean > 0 ? swing_of(forces, 0.75, 1).mean / depth.mean : 0;
  out.coupling = coupling.stiffness();
  out.damped_ticks = passivity.damped_ticks();
  out.returned = std::max(0.0, -passivity.least());
  out.hash = hash.value();
  return out;
}

}  // namespace kt
