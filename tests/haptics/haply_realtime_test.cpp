// The driver against a service without a device, which has a hand behind it: poses come, forces arrive, and whatever
// becomes of the service, the force it was told last is zero and nothing is ever beyond the limit. Waits are generous:
// the machine may be busy.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/device_test.hpp"
#include "haptics/guard/guarded_device.hpp"
#include "tests/fakes/haply_service.hpp"

namespace kt {
namespace {

DeviceOptions options_for(const FakeHaply& service) {
  DeviceOptions out;
  out.live.name = "haply";
  out.live.address = service.address();
  out.live.origin = Vec3(0, 0.12, -0.15);  // the fake's place at rest is the world's zero
  return out;
}

/// Ticks a constant demand of 2 N upwards for so long, and hands over what happens at each.
template <class Each>
void tick_for(GuardedDevice& device, double seconds, Each each) {
  const std::int64_t began = monotonic_ns();
  std::int64_t before = began;
  for (int i = 0; 1e-9 * static_cast<double>(monotonic_ns() - began) < seconds; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(800));
    const std::int64_t now = monotonic_ns();
    const double dt = std::max(1e-9, 1e-9 * static_cast<double>(now - before));
    before = now;
    device.pose(i * 1e-3, dt);
    LocalFrame frame;
    frame.force = {0, 0, 2};
    device.give(frame, 1e-3, dt);
    each(frame);
  }
}

/// Until the gate is open; false: this machine is too busy to have fresh poses for half a second on end.
bool opens(GuardedDevice& device) {
  for (int i = 0; i < 60 && device.chain().gate() < 1; ++i) tick_for(device, 0.2, [](const LocalFrame&) {});
  return device.chain().gate() == 1;
}

const char* const kTooBusy = "the machine is too busy: poses are older than 5 ms again and again";

/// Without a coupling: its force would be the tick's only when the body answers to the tool.
SafetyOptions usual() { return {.h = 1e-3, .max_slew = 200, .coupling = 0}; }

/// No device would open: a new one, at a service of its own, does not either. Else what did not open has a fault.
bool is_too_busy() {
  FakeHaply service({});
  GuardedDevice fresh(make_device("haply", options_for(service)), usual());
  return !opens(fresh);
}

double most_force(const std::vector<HeardForce>& heard) {
  double out = 0;
  for (const HeardForce& h : heard) out = std::max(out, h.force.norm());
  return out;
}

TEST(Haply, PosesComeAndForcesArrive) {
  FakeHaply service({.target = [](double) { return Vec3(0, -0.12, 0.15); }});
  {
    GuardedDevice device(make_device("haply", options_for(service)), usual());
    EXPECT_EQ(device.device().info().name, "Inverse3");
    EXPECT_EQ(device.device().info().serial, "049D");
    EXPECT_TRUE(device.device().info().is_live);
    const bool is_open = opens(device);
    EXPECT_GT(device.chain().counts().ticks - device.chain().counts().stale, 50) << "fresh poses, however busy";
    if (!is_open) GTEST_SKIP() << kTooBusy;
    tick_for(device, 0.3, [](const LocalFrame&) {});
    for (int i = 0; i < 50 && std::abs(device.pose(0, 1e-3).x.z() - 2.0 / 300) > 5e-4; ++i)  // on a busy machine
      tick_for(device, 0.1, [](const LocalFrame&) {});
    if (device.chain().gate() < 1) GTEST_SKIP() << kTooBusy;
    EXPECT_NEAR(device.pose(0, 1e-3).x.z(), 2.0 / 300, 5e-4) << "2 N against a grip of 300 N/m";
    EXPECT_EQ(device.state().buttons, 1u);
    EXPECT_GT(device.state().delays, 0u);
    EXPECT_GT(device.state().delay, 0) << "of a message: the motors' half a millisecond is not told";
  }
  const auto heard = service.heard();
  EXPECT_GT(heard.size(), 200u);
  EXPECT_NEAR(most_force(heard), 2, 1e-6);
  EXPECT_TRUE(heard.back().force.isZero(0)) << "let go at the end";
  int zeros = 0;
  for (auto it = heard.rbegin(); it != heard.rend() && it->force.isZero(0); ++it) ++zeros;
  EXPECT_GT(zeros, 3) << "for 50 ms";
}

/// Each fault in turn: the force fades, nothing beyond the limit is written, and afterwards it comes back slowly.
TEST(Haply, WhateverBecomesOfTheServiceTheForceIsSafe) {
  for (const char* fault : {"hangs", "dies", "silent", "nan", "truncated", "no device", "uncalibrated"}) {
    FakeHaply service({});
    GuardedDevice device(make_device("haply", options_for(service)), usual());
    if (!opens(device)) GTEST_SKIP() << kTooBusy;
    const std::string name = fault;
    if (name == "hangs") service.hang(200);
    if (name == "dies") service.die();
    if (name == "silent") service.set_fault(HaplyFault::silent);
    if (name == "nan") service.set_fault(HaplyFault::nan);
    if (name == "truncated") service.set_fault(HaplyFault::truncated);
    if (name == "no device") service.set_fault(HaplyFault::no_device);
    if (name == "uncalibrated") service.set_fault(HaplyFault::uncalibrated);
    const std::int64_t began = monotonic_ns();
    double zero_after = -1;
    tick_for(device, 0.25, [&](const LocalFrame& frame) {
      if (zero_after < 0 && frame.force.isZero(0)) zero_after = 1e-9 * static_cast<double>(monotonic_ns() - began);
    });
    EXPECT_GT(zero_after, 0) << fault << ": the force stays";
    EXPECT_LT(zero_after, 0.2) << fault;  // 20 ms, on a machine that is not busy
    service.set_fault(HaplyFault::none);
    service.live();
    tick_for(device, name == "dies" ? 1.2 : 0.3, [](const LocalFrame&) {});
    if (!opens(device)) {  // it comes back
      ASSERT_TRUE(is_too_busy()) << fault
                                 << ": a new device opens, this one does not: " << name_of(device.chain().reason());
      GTEST_SKIP() << kTooBusy;
    }
    EXPECT_LE(most_force(service.heard()), 2 + 1e-9) << fault;
    for (const HeardForce& h : service.heard()) ASSERT_TRUE(h.force.allFinite()) << fault;
  }
}

/// The tick hangs: the device's own thread writes zeros.
TEST(Haply, WhenTheTickHangsTheDeviceIsLetGo) {
  FakeHaply service({});
  GuardedDevice device(make_device("haply", options_for(service)), usual());
  if (!opens(device)) GTEST_SKIP() << kTooBusy;
  const double stopped = service.now();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  double last_force = stopped;
  bool was_zero = false;
  for (const HeardForce& h : service.heard()) {
    if (h.t <= stopped) continue;
    if (h.force.isZero(0))
      was_zero = true;
    else
      last_force = h.t;
  }
  EXPECT_TRUE(was_zero);
  EXPECT_LT(last_force - stopped, 0.2) << "20 ms, on a machine that is not busy";
}

TEST(Haply, WhatIsNotThereIsToldInOneLine) {
  const auto error = [](DeviceOptions options) -> std::string {
    try {
      make_device("haply", options);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  DeviceOptions nobody;
  nobody.live.address = "ws://localhost:1";
  EXPECT_NE(error(nobody).find("ws://localhost:1: Connection refused; is the Haply Inverse Service running"),
            std::string::npos)
      << error(nobody);
  nobody.live.address = "http://x";
  EXPECT_NE(error(nobody).find("must be ws://HOST:PORT"), std::string::npos);
  FakeHaply two({.ids = {"049D", "0512"}});
  EXPECT_NE(error(options_for(two)).find("049D, 0512"), std::string::npos) << error(options_for(two));
  DeviceOptions other = options_for(two);
  other.live.id = "0513";
  EXPECT_NE(error(other).find("0512"), std::string::npos) << "did you mean: " << error(other);
  other.live.id = "0512";
  EXPECT_EQ(error(other), "");
}

/// Poses pushed by the program around the engine, forces back to it.
TEST(Pushed, ThePosesAreThePrograms) {
  auto slots = std::make_shared<DeviceSlots>();
  DeviceReading reading;
  reading.x[2] = 0.02;
  reading.at_ns = monotonic_ns();
  reading.count = 1;
  slots->reading.put(reading);
  slots->health = DeviceHealth::ok;
  DeviceOptions options;
  options.slots = slots;
  options.live.name = "pushed";
  options.live.axes = "ZXY";
  options.live.origin = Vec3(1, 1, 1);
  options.live.scale = 2;
  const auto device = make_device("pushed", options);
  EXPECT_TRUE(device->pose(0).x.isApprox(Vec3(1.04, 1, 1)));
  device->write({.force = {1, 2, 3}}, 1e-3);
  const DeviceOrder order = slots->wanted(monotonic_ns());
  EXPECT_EQ(Vec3(order.force[0], order.force[1], order.force[2]), Vec3(2, 3, 1)) << "the world's y is the device's x";
  EXPECT_THROW(make_device("pushed", {}), InputError);
}

/// The wall that `kilotouch device test` renders. A gate that shuts because this machine stood still for 5 ms lets the
/// hand through the wall, as it should; a trial counts where it stayed open from the first half second on.
TEST(DeviceTest, MeasuresWhileAHandPressesOnTheWall) {
  constexpr int kTicksToOpen = 500;
  const auto trial = [] {
    FakeHaply service(
        {.target = [](double t) { return Vec3(0, -0.12, 0.15 - std::min(0.02, 0.05 * std::max(0.0, t - 0.9))); }});
    const auto device = make_device("haply", options_for(service));
    return test_device(*device, {.seconds = 2.5});
  };
  DeviceTest test;
  for (int i = 0; i < 6; ++i) {
    test = trial();
    EXPECT_EQ(test.ticks, 2500);
    EXPECT_LE(test.safety.most_force, 3) << "whatever the gate did";
    EXPECT_LT(test.deepest, 0.0101) << "without any force it is where its target is";
    if (test.safety.gated <= kTicksToOpen + 50) break;
  }
  if (test.safety.gated > kTicksToOpen + 50) GTEST_SKIP() << kTooBusy;
  // 20 mm down, the wall at 10: grip of 300 N/m against the wall's 200.
  EXPECT_NEAR(test.deepest, 0.006, 2e-3);
  EXPECT_GT(test.readings_per_s, 200);
  EXPECT_FALSE(test.delay.empty());
  EXPECT_NEAR(test.low.z(), -0.016, 2e-3);
}

}  // namespace
}  // namespace kt
