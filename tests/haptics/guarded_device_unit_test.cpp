// What a device is given: the force, limited; nothing while its poses cannot be relied upon.
#include <gtest/gtest.h>

#include "apps/console/allocation_counter.hpp"
#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/guarded_device.hpp"

namespace kt {
namespace {

struct Seen {
  DeviceHealth health = DeviceHealth::ok;
  Wrench written;
};

class Fake final : public HapticDevice {
 public:
  explicit Fake(Seen& seen) : seen_(seen) {}
  Pose pose(double) noexcept override { return {}; }
  void write(const Wrench& wrench, double) noexcept override { seen_.written = wrench; }
  DeviceInfo info() const override { return {.max_force = 2}; }
  DeviceState state() const noexcept override { return {.health = seen_.health}; }
  double max_speed() const override { return 1; }

 private:
  Seen& seen_;
};

TEST(GuardedDevice, GivesNothingToADeviceWhosePosesCannotBeReliedUpon) {
  Seen seen;
  GuardedDevice hand(std::make_unique<Fake>(seen), {.h = 1e-3});
  const auto give = [&](DeviceHealth health) {
    seen.health = health;
    LocalFrame frame;
    hand.pose(0, 1e-3);
    frame.force = {0, 0, 3};
    frame.torque = {0.1, 0, 0};
    EXPECT_EQ(hand.give(frame, 1e-3, 1e-3), Vec3(0, 0, 3)) << "the model's own stays on record";
    EXPECT_EQ(frame.force, seen.written.force) << "what is recorded is what was written";
    return seen.written;
  };
  EXPECT_NEAR(give(DeviceHealth::ok).force.z(), 2, 1e-12);
  EXPECT_EQ(seen.written.torque, Vec3(0.1, 0, 0));
  for (const DeviceHealth bad :
       {DeviceHealth::stale, DeviceHealth::gone, DeviceHealth::fault, DeviceHealth::uncalibrated}) {
    EXPECT_TRUE(give(bad).force.isZero(0));
    EXPECT_TRUE(seen.written.torque.isZero(0));
  }
  EXPECT_NEAR(give(DeviceHealth::ok).force.z(), 2, 1e-12);
}

/// The limit cuts both parts alike; what is not given has no parts.
TEST(GuardedDevice, PartsOfTheForceAreOfTheForceThatWasGiven) {
  Seen seen;
  GuardedDevice hand(std::make_unique<Fake>(seen), {.h = 1e-3});
  const auto give = [&](DeviceHealth health) {
    seen.health = health;
    LocalFrame frame;
    frame.mode = ContactMode::slide;
    hand.pose(0, 1e-3);
    frame.force = {2.4, 0, 3.2};
    frame.normal = Vec3::UnitZ();
    frame.f_n = 3.2;
    frame.f_t = 2.4;
    hand.give(frame, 1e-3, 1e-3);
    return frame;
  };
  const LocalFrame cut = give(DeviceHealth::ok);
  EXPECT_NEAR(cut.f_n, 1.6, 1e-12);
  EXPECT_NEAR(cut.f_t, 1.2, 1e-12);
  const LocalFrame none = give(DeviceHealth::gone);
  EXPECT_NEAR(none.f_n, 0, 1e-12);
  EXPECT_NEAR(none.f_t, 0, 1e-12);
}

/// Of a live device with all stages.
TEST(GuardedDevice, ATickAllocatesNothing) {
  if (thread_allocations() < 0) GTEST_SKIP() << "this build cannot count";
  const auto slots = std::make_shared<DeviceSlots>();
  DeviceReading reading;
  reading.count = 1;
  reading.at_ns = monotonic_ns();
  slots->reading.put(reading);
  slots->health = DeviceHealth::ok;
  DeviceOptions options;
  options.slots = slots;
  GuardedDevice device(make_device("pushed", options), {.most_damping = 20});
  const long long before = thread_allocations();
  for (int i = 0; i < 2000; ++i) {
    reading.at_ns = monotonic_ns();
    reading.x[2] = 1e-5 * (i % 100);
    reading.delay = 1e-3;
    ++reading.delays;
    slots->reading.put(reading);
    device.pose(1e-3 * i, 1e-3);
    LocalFrame frame;
    frame.force = {0, 0, 0.01 * (i % 100)};
    frame.torque = {0.01, 0, 0};
    device.give(frame, 1e-3, 1e-3);
  }
  EXPECT_EQ(thread_allocations(), before);
}

}  // namespace
}  // namespace kt
