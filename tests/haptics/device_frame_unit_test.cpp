// A device's axes in the world, and the slot between its thread and the tick.
#include "haptics/driver/device_frame.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "core/base/error.hpp"
#include "haptics/driver/device_slots.hpp"

namespace kt {
namespace {

TEST(DeviceFrame, AxesAreNamedFromTheWorldsSide) {
  EXPECT_EQ(device_axes("XYZ"), Mat3::Identity());
  const Mat3 r = device_axes("X-ZY");
  EXPECT_EQ(r * Vec3(1, 2, 3), Vec3(1, -3, 2)) << "the world's y is the device's -z, its z the device's y";
  const DeviceFrame frame{r, {0.1, 0.2, 0.3}, 4};
  EXPECT_TRUE(frame.to_world(Vec3(0.01, 0.02, 0.03)).isApprox(Vec3(0.14, 0.08, 0.38)));
  EXPECT_TRUE(frame.to_world(Quaternion(Eigen::AngleAxisd(1, Vec3::UnitY())))
                  .isApprox(Quaternion(r) * Quaternion(Eigen::AngleAxisd(1, Vec3::UnitY()))));
  EXPECT_TRUE((frame.origin_for({1, 2, 3}, {5, 6, 7}) + 4 * r * Vec3(1, 2, 3)).isApprox(Vec3(5, 6, 7)));
}

TEST(DeviceFrame, RefusesWhatIsNoTurn) {
  for (const char* axes : {"", "XY", "XYX", "XYZX", "xyz", "--XYZ", "XY-", "-XYZ", "YXZ", "XYW"})
    EXPECT_THROW(device_axes(axes), InputError) << axes;
  for (const char* axes : {"YZX", "-YXZ", "-X-YZ", "Z-YX"}) EXPECT_NEAR(device_axes(axes).determinant(), 1, 0) << axes;
}

/// A reader never sees half of one value and half of another.
TEST(Slot, ValuesAreWhole) {
  Slot<DeviceOrder> slot;
  std::atomic<bool> is_over{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i < 200000; ++i) {
      DeviceOrder order;
      order.count = i;
      for (double& f : order.force) f = static_cast<double>(i);
      for (double& f : order.torque) f = -static_cast<double>(i);
      slot.put(order);
    }
    is_over = true;
  });
  std::uint64_t newest = 0;
  while (!is_over) {
    DeviceOrder seen;
    if (!slot.read(seen)) continue;
    ASSERT_GE(seen.count, newest);
    newest = seen.count;
    for (double f : seen.force) ASSERT_EQ(f, static_cast<double>(seen.count));
    for (double f : seen.torque) ASSERT_EQ(f, -static_cast<double>(seen.count));
  }
  writer.join();
}

TEST(DeviceSlots, AnOldOrderIsNone) {
  DeviceSlots slots;
  EXPECT_EQ(slots.wanted(monotonic_ns()).force[2], 0) << "before the first";
  DeviceOrder order;
  order.force[2] = 2;
  order.at_ns = 1'000'000'000;
  order.count = 1;
  slots.order.put(order);
  EXPECT_EQ(slots.wanted(1'019'000'000).force[2], 2);
  EXPECT_EQ(slots.wanted(1'021'000'000).force[2], 0) << "the tick hangs";
  order.force[1] = std::numeric_limits<double>::quiet_NaN();
  slots.order.put(order);
  EXPECT_EQ(slots.wanted(1'001'000'000).force[2], 0) << "what is no number goes to no device";
}

}  // namespace
}  // namespace kt
