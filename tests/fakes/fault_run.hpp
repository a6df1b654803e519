#pragma once
// A fault under the hand: a stylus is pressed into a soft wall 1000 times a second, through LiveDevice and SafetyChain,
// and something breaks. What the device was given, period by period, is what its stand-in has written down.
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/driver/live_device.hpp"
#include "haptics/guard/safety_chain.hpp"
#include "tests/fakes/fake_library.hpp"

namespace kt::fake {

/// Beside the device's own faults, what happens on our side of it.
enum class Ours { nothing, tick_stops, closed };

struct FaultCase {
  const char* name;
  Fault fault;
  Ours ours;
  bool shuts;  ///< the force has to become zero
  bool shuts_for(const std::string& backend) const {
    return shuts || (fault == Fault::saturated && backend == "openhaptics");  // an error there, and none at the other
  }
};

inline constexpr FaultCase kFaultCases[] = {
    {"none", Fault::none, Ours::nothing, false},           {"NaN", Fault::nan, Ours::nothing, true},
    {"hangs 200 ms", Fault::hang, Ours::nothing, true},    {"dead", Fault::dead, Ours::nothing, true},
    {"unplugged", Fault::gone, Ours::nothing, true},       {"uncalibrated", Fault::uncalibrated, Ours::nothing, true},
    {"saturated", Fault::saturated, Ours::nothing, false}, {"tick stops", Fault::none, Ours::tick_stops, true},
    {"closed", Fault::none, Ours::closed, true},
};

struct FaultResult {
  bool was_finite = true;
  double most_force = 0;        ///< that the device got [N]
  double most_step = 0;         ///< from one of its periods to the next [N]
  double zero_ms = 0;           ///< from the fault until the device got a zero that stayed
  double back_ms = 0;           ///< from the fault's end until it got a force again; not a number: never
  double late_ms = 0;           ///< longest time between two ticks
  double silent_ms = 0;         ///< longest time between two periods of the device, from the fault to the last force
  bool were_zeros_last = true;  ///< 45 ms of nothing but zeros before the device was closed
};

/// How long it is pressed, and how long the fault lasts [s]; it comes when the device has got at least `force` [N].
struct FaultTimes {
  double before = 0.8, fault = 0.3, force = 1;
};

/// The hand: presses 0 to 20 mm into a wall of 500 N/m, at the world's z = 0, twice a second.
class PressedWall {
 public:
  PressedWall(HapticDevice& device, Device& stylus) : device_(device), stylus_(stylus), chain_(options(device)) {}

  /// Ticks until that time [ns of the monotonic clock], or until `is_enough`.
  template <class IsEnough>
  void tick_until(std::int64_t end, const IsEnough& is_enough) {
    std::int64_t due = now_ns();
    while (now_ns() < end && !is_enough()) {
      tick();
      due = std::max(due + 1'000'000, now_ns() - 1'000'000);
      sleep_until_ns(due);
    }
  }
  void tick_for(double seconds) {
    tick_until(now_ns() + static_cast<std::int64_t>(1e9 * seconds), [] { return false; });
  }
  /// As a run ends: the gate shuts first.
  void put_down() {
    chain_.shut();
    tick_for(0.03);
  }
  double late_ms() const { return late_ms_; }
  void forget_lateness() { late_ms_ = 0; }

 private:
  static SafetyOptions options(const HapticDevice& device) {
    SafetyOptions out;
    out.device = device.info();
    out.most_damping = 5;
    return out;
  }

  void tick() {
    const std::int64_t now = now_ns();
    const double dt = before_ == 0 ? 1e-3 : std::max(1e-9, 1e-9 * static_cast<double>(now - before_));
    late_ms_ = std::max(late_ms_, 1e3 * dt);
    before_ = now;
    const double t = 1e-9 * static_cast<double>(now - begin_);
    const double angle = 4 * static_cast<double>(EIGEN_PI) * t;
    stylus_.x[2] = -0.01 * (1 + std::sin(angle));
    LocalFrame frame;
    const Pose at = device_.pose(t);
    frame.pose = chain_.tool(at, dt);
    frame.force.z() = std::max(0.0, -500 * frame.pose.x.z());
    if (frame.force.z() > 0) frame.normal = Vec3::UnitZ();
    frame.f_n = frame.force.z();
    device_.write(chain_.make_safe(frame, at, device_.state(), dt), 1e-3);
  }

  HapticDevice& device_;
  Device& stylus_;
  SafetyChain chain_;
  std::int64_t before_ = 0;
  const std::int64_t begin_ = now_ns();
  double late_ms_ = 0;
};

inline double ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }
inline double norm(const Given& given) { return std::hypot(given.f[0], given.f[1], given.f[2]); }

/// From opening a device until it has been closed, with a fault in between.
/// @param backend  openhaptics or forcedimension
inline FaultResult run_fault(const std::string& backend, const FaultCase& c, const FaultTimes& times) {
  const std::string file = backend == "openhaptics" ? "libHD.so" : "libdhd.so";
  Device& stylus = device(file);
  const std::size_t first = stylus.given;
  DeviceOptions o;
  o.live.name = backend;
  o.live.library = library(file);
  o.live.origin = Vec3::Zero();
  auto live = make_device(backend, o);
  PressedWall wall(*live, stylus);
  wall.tick_for(times.before);
  const auto last_force = [&] { return norm(stylus.log[stylus.given - 1]); };
  wall.tick_until(now_ns() + 2'000'000'000, [&] { return last_force() > times.force; });
  wall.forget_lateness();

  FaultResult out;
  const std::int64_t from = now_ns();
  stylus.fault = c.fault;
  const std::int64_t end = from + static_cast<std::int64_t>(1e9 * times.fault);
  if (c.fault == Fault::hang)  // it ends by itself
    wall.tick_until(from + 1'000'000'000, [&] { return stylus.fault == Fault::none; });
  else if (c.ours == Ours::nothing)
    wall.tick_until(end, [] { return false; });
  if (c.ours == Ours::tick_stops) sleep_until_ns(end);
  if (c.ours == Ours::closed) live.reset();
  const std::int64_t until = now_ns();
  stylus.fault = Fault::none;
  const std::size_t at_end = stylus.given;
  out.late_ms = wall.late_ms();
  if (live) {
    wall.tick_until(until + 3'000'000'000, [&] { return stylus.given > at_end && last_force() > 0.01; });
    out.back_ms = last_force() > 0.01 ? ms(now_ns() - until) : NAN;
    wall.put_down();
  } else {
    out.back_ms = NAN;
  }
  live.reset();

  // A force holds until the device is given the next one.
  out.zero_ms = 0;
  for (std::size_t i = first; i < stylus.given; ++i) {
    const Given& now = stylus.log[i];
    const double size = norm(now);
    out.was_finite = out.was_finite && std::isfinite(size);
    out.most_force = std::max(out.most_force, size);
    if (i > first)
      out.most_step =
          std::max(out.most_step, std::hypot(now.f[0] - stylus.log[i - 1].f[0], now.f[1] - stylus.log[i - 1].f[1],
                                             now.f[2] - stylus.log[i - 1].f[2]));
    if (size > 0 && now.at_ns < until && i + 1 < stylus.given) out.zero_ms = ms(stylus.log[i + 1].at_ns - from);
  }
  for (std::size_t i = first + 1; i < stylus.given; ++i)
    if (stylus.log[i].at_ns >= from && ms(stylus.log[i - 1].at_ns - from) < out.zero_ms)
      out.silent_ms = std::max(out.silent_ms, ms(stylus.log[i].at_ns - stylus.log[i - 1].at_ns));
  const std::int64_t last = stylus.log[stylus.given - 1].at_ns;
  for (std::size_t i = stylus.given; i-- > first && last - stylus.log[i].at_ns < 45'000'000;)
    out.were_zeros_last = out.were_zeros_last && norm(stylus.log[i]) == 0;
  return out;
}

}  // namespace kt::fake
