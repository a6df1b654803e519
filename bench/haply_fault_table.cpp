// What a Haply Inverse3 gets when something breaks: a stand-in of its service with a hand behind it, the engine's
// driver and its safety chain.
//   haply_fault_table       prints fault -> largest force, largest change from message to message, ms until the first
//                           zero, ms from the fault's end until a force again
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/guarded_device.hpp"
#include "haptics/guard/sleep_until.hpp"
#include "tests/fakes/haply_service.hpp"

namespace kt {
namespace {

/// A wall of 500 N/m at the world's z = 0, ticked by the clock.
class Wall {
 public:
  explicit Wall(const FakeHaply& service) {
    DeviceOptions options;
    options.live.address = service.address();
    options.live.origin = Vec3(0, 0.12, -0.15);
    device_.emplace(make_device("haply", options), SafetyOptions{.most_damping = 20});
  }
  void press(double seconds) {
    std::int64_t due = monotonic_ns();
    const std::int64_t end = due + std::llround(1e9 * seconds);
    for (; due < end; due += 1'000'000) {
      sleep_until_ns(due);
      const std::int64_t now = monotonic_ns();
      const double dt = before_ == 0 ? 1e-3 : std::max(1e-9, 1e-9 * static_cast<double>(now - before_));
      before_ = now;
      LocalFrame frame;
      frame.pose = device_->pose(0, dt);
      frame.force.z() = frame.f_n = std::max(0.0, -500 * frame.pose.x.z());
      if (frame.f_n > 0) frame.normal = Vec3::UnitZ();
      device_->give(frame, 1e-3, dt);
    }
  }
  void close() { device_.reset(); }
  const GuardedDevice& device() const { return *device_; }

 private:
  std::optional<GuardedDevice> device_;
  std::int64_t before_ = 0;
};

void print(const char* name, const std::vector<HeardForce>& heard, double from, double until) {
  double most = 0, step = 0, zero = NAN, again = NAN;
  bool is_finite = true;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    const double size = heard[i].force.norm();
    is_finite = is_finite && std::isfinite(size);
    most = std::max(most, size);
    if (i > 0) step = std::max(step, (heard[i].force - heard[i - 1].force).norm());
    if (heard[i].t > from && size == 0 && std::isnan(zero)) zero = heard[i].t;
    if (heard[i].t > until && size > 0 && std::isnan(again)) again = heard[i].t - until;
  }
  std::printf("%-14s %9.3f %9.3f %10.1f %11.1f%s%s\n", name, most, step, 1e3 * (zero - from), 1e3 * again,
              is_finite ? "" : "  NOT FINITE", heard.back().force.isZero(0) ? "" : "  NO ZERO AT THE END");
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main() {
  using kt::HaplyFault;
  std::puts("fault          force [N]  step [N]  zero [ms]  again [ms]");
  for (const std::string name : {"hangs 200 ms", "dies", "NaN", "truncated", "silent", "no device", "uncalibrated",
                                 "saturated", "tick stops", "closed"}) {
    kt::FakeHaply service({.target = [](double t) { return kt::Vec3(0, -0.12, 0.15 - 0.02 * std::min(1.0, t)); }});
    kt::Wall wall(service);
    wall.press(2.5);
    const double from = service.now();
    if (name == "hangs 200 ms") service.hang(200);
    if (name == "dies") service.die();
    if (name == "NaN") service.set_fault(HaplyFault::nan);
    if (name == "truncated") service.set_fault(HaplyFault::truncated);
    if (name == "silent") service.set_fault(HaplyFault::silent);
    if (name == "no device") service.set_fault(HaplyFault::no_device);
    if (name == "uncalibrated") service.set_fault(HaplyFault::uncalibrated);
    if (name == "saturated") service.set_fault(HaplyFault::saturated);
    if (name == "closed") wall.close();
    if (name == "tick stops" || name == "closed")
      kt::sleep_until_ns(kt::monotonic_ns() + 300'000'000);
    else
      wall.press(0.3);
    const double until = service.now();
    service.set_fault(HaplyFault::none);
    service.live();
    if (name != "closed") {
      wall.press(2.5);
      wall.close();
    }
    kt::print(name.c_str(), service.heard(), from, until);
  }
}
