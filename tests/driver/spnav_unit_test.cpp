// The 6-axis mouse by a stand-in of its daemon: speed from deflection, rest, buttons, and a daemon that comes and goes.
#include <gtest/gtest.h>

#include <cstdlib>

#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/live_device.hpp"
#include "tests/fakes/fake_library.hpp"
#include "tests/fakes/fake_spacenavd.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

using fake::becomes;

class Spacemouse : public testing::Test {
 protected:
  void SetUp() override {
    options_.live.name = "spnav";
    options_.live.address = path_;
    options_.live.origin = Vec3::Zero();
    options_.slots = slots_;
  }
  void open() {
    device_ = make_device("spnav", options_);
    daemon_.accept();
    EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
  }
  DeviceHealth health() {
    pose_ = device_->pose(0);
    return device_->state().health;
  }
  Vec3 velocity() {
    device_->pose(0);
    return device_->state().v.value();
  }
  /// Speed and place between two readings, whenever the threads ran.
  Vec3 moved_per_second() {
    DeviceReading a, b;
    slots_->reading.read(a);
    becomes([&] { return slots_->reading.read(b) && b.count > a.count + 20; });
    return Vec3(b.x[0] - a.x[0], b.x[1] - a.x[1], b.x[2] - a.x[2]) / (1e-9 * static_cast<double>(b.at_ns - a.at_ns));
  }

  const std::string path_ = text("/tmp/kt_spnav_", getpid());
  fake::Spacenavd daemon_{path_};
  std::shared_ptr<DeviceSlots> slots_ = std::make_shared<DeviceSlots>();
  DeviceOptions options_;
  std::unique_ptr<HapticDevice> device_;
  Pose pose_;
};

TEST_F(Spacemouse, DeflectionIsSpeed) {
  open();
  EXPECT_FALSE(device_->info().gives_force);
  EXPECT_FALSE(device_->info().yields);
  daemon_.motion(350, 70, -175);  // right, up, towards the person
  EXPECT_TRUE(becomes([&] { return (velocity() - Vec3(0.1, -0.05, 0.02)).norm() < 1e-12; }));
  daemon_.motion(350, 70, -175);
  const Vec3 moved = moved_per_second();
  EXPECT_GT(moved.x(), 0);  // as fast, or slower where a thread was held up: never faster
  EXPECT_LE(moved.x(), 0.1 + 1e-9);
  EXPECT_NEAR(moved.y() / moved.x(), -0.5, 1e-9);
  EXPECT_NEAR(moved.z() / moved.x(), 0.2, 1e-9);
}

TEST_F(Spacemouse, NeverFasterThanItsSpeed) {
  options_.live.speed = 0.02;
  open();
  daemon_.motion(2147483647, -2147483647 - 1, 0, 2147483647, 0, 0);
  EXPECT_TRUE(becomes([&] { return (velocity() - Vec3(0.02, 0, -0.02)).norm() < 1e-12; }));
}

TEST_F(Spacemouse, TurnsAboutTheUpAxis) {
  open();
  becomes([&] {
    daemon_.motion(0, 0, 0, 0, 350, 0);
    return health() == DeviceHealth::ok && Eigen::AngleAxisd(pose_.r).angle() > 0.02;
  });
  const Eigen::AngleAxisd turn(pose_.r);
  EXPECT_LT((turn.axis() - Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(pose_.r.norm(), 1, 1e-12);
}

TEST_F(Spacemouse, RestsWhenTheDaemonIsSilent) {
  open();
  daemon_.motion(350, 0, 0);
  EXPECT_TRUE(becomes([&] { return velocity().x() > 0; }));
  EXPECT_TRUE(becomes([&] { return velocity().norm() == 0; }));
  EXPECT_EQ(moved_per_second().norm(), 0);
  EXPECT_EQ(health(), DeviceHealth::ok) << "silence is rest, not a fault: its poses are fresh";
}

TEST_F(Spacemouse, HasButtonsAndTakesEventsInPieces) {
  open();
  const std::int32_t press[8] = {1, 2, 0, 0, 0, 0, 0, 0};
  daemon_.send_bytes(press, 5);
  daemon_.send_bytes(reinterpret_cast<const char*>(press) + 5, sizeof press - 5);
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok && device_->state().buttons == 4; }));
  daemon_.button(40, true);  // no such
  daemon_.button(-1, true);
  daemon_.send({77, 1, 2, 3, 4, 5, 6, 7});  // an event of later protocols
  daemon_.button(2, false);
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok && device_->state().buttons == 0; }));
}

TEST_F(Spacemouse, ComesBackWithItsDaemon) {
  open();
  daemon_.motion(350, 0, 0);
  EXPECT_TRUE(becomes([&] { return velocity().x() > 0; }));
  daemon_.stop();
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::gone; }));
  const Vec3 place = pose_.x;
  daemon_.start();
  daemon_.accept();
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
  EXPECT_EQ(pose_.x, place) << "and rests where it was";
}

TEST_F(Spacemouse, ThatThereIsNoDaemonIsSaid) {
  daemon_.stop();
  const std::string expected = path_ + ": No such file or directory; is spacenavd running?";
  EXPECT_EQ(message([&] { make_device("spnav", options_); }), "tool.path.device: spnav: " + expected);
  const auto found = find_devices("spnav", options_.live);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].trouble, expected);
}

TEST_F(Spacemouse, IsFoundByTheEnvironment) {
  ::setenv("SPNAV_SOCKET", path_.c_str(), 1);
  const auto found = find_devices("spnav", {});
  ::unsetenv("SPNAV_SOCKET");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, path_);
  EXPECT_EQ(found[0].trouble, "");
}

}  // namespace
}  // namespace kt
