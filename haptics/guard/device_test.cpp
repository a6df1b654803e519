#include "haptics/guard/device_test.hpp"

#include <algorithm>
#include <cmath>

#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/sleep_until.hpp"
#include "haptics/machine/real_time_thread.hpp"
#include "haptics/safety/passivity.hpp"

namespace kt {
namespace {

/// Largest minus smallest over the mean of the force, over the last half second in the wall.
class Ripple {
 public:
  explicit Ripple(double h) : window_(static_cast<std::size_t>(std::lround(0.5 / h))) {}
  void add(double force) {
    if (!(force > 0)) {
      forces_.clear();
      return;
    }
    forces_.push_back(force);
    if (forces_.size() < window_) return;
    const auto [low, high] = std::ranges::minmax(forces_);
    double sum = 0;
    for (double f : forces_) sum += f;
    last_ = (high - low) * static_cast<double>(forces_.size()) / sum;
    forces_.clear();
  }
  double last() const { return last_; }

 private:
  std::size_t window_;
  std::vector<double> forces_;
  double last_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace

double sorted_percentile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

DeviceTest test_device(HapticDevice& device, const DeviceTestOptions& options) {
  DeviceTest out;
  SafetyOptions safety = options.safety;
  safety.device = device.info();
  safety.h = options.h;
  SafetyChain chain(safety);
  const RealTimeThread on_time;
  Ripple ripple(options.h);
  const auto ticks = static_cast<int>(std::lround(options.seconds / options.h));
  const double scale = safety.scale;
  const double wall = device.pose(0).x.z() / scale - options.wall_below;
  out.low = out.high = device.pose(0).x;
  const std::int64_t began = monotonic_ns(), period = std::llround(1e9 * options.h);
  std::int64_t before = began;
  unsigned delays = device.state().delays;
  double last_stamp = -1;
  int fresh = 0;
  for (int i = 0; i < ticks && !(options.stop && options.stop->load()); ++i) {
    const std::int64_t due = began + i * period;
    sleep_until_ns(due);
    const std::int64_t now = monotonic_ns();
    out.lateness.push_back(1e-9 * static_cast<double>(now - due));
    const Pose at = device.pose(1e-9 * static_cast<double>(now - began));
    const DeviceState state = device.state();
    const double stamp = 1e-9 * static_cast<double>(now) - state.age;
    out.pose_age.push_back(state.age);
    if (state.delays != delays) out.delay.push_back(state.delay);
    delays = state.delays;
    const double dt = i == 0 ? options.h : std::max(1e-9, 1e-9 * static_cast<double>(now - before));
    before = now;
    const bool is_there = state.health == DeviceHealth::ok || state.health == DeviceHealth::stale;
    fresh += is_there && std::abs(stamp - last_stamp) > 1e-6;
    out.there += is_there ? dt : 0;
    last_stamp = stamp;
    LocalFrame frame;
    frame.pose = chain.tool(at, dt);
    const double depth = wall - frame.pose.x.z() / scale;
    if (depth > 0) frame.force.z() = options.wall_stiffness * depth / safety.force_scale;
    const Wrench given = chain.make_safe(frame, at, state, dt);
    device.write(given, options.h);
    out.deepest = std::max(out.deepest, depth);
    ripple.add(chain.gate() == 1 ? given.force.z() : 0);
    out.low = out.low.cwiseMin(at.x);
    out.high = out.high.cwiseMax(at.x);
    out.buttons |= state.buttons;
    if (options.progress && i % std::max(1, static_cast<int>(0.5 / options.h)) == 0)
      options.progress(i * options.h, at, state, given.force.norm(), chain.gate());
    out.ticks = i + 1;
  }
  out.seconds = 1e-9 * static_cast<double>(monotonic_ns() - began);
  out.readings_per_s = fresh / std::max(out.there, 1e-9);
  out.notes = device.notes();
  out.safety = chain.counts();
  out.gate = chain.reason();
  out.ripple = ripple.last();
  if (chain.passivity()) out.given = std::max(0.0, -chain.passivity()->least());
  for (auto* list : {&out.pose_age, &out.delay, &out.lateness}) std::ranges::sort(*list);
  return out;
}

}  // namespace kt
