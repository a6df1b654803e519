// OpenHaptics and Force Dimension by stand-ins of their libraries: units, frames, calibration, faults, and the lines
// that say what a person has to do.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/live_device.hpp"
#include "tests/fakes/fake_library.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

using fake::becomes;
using fake::Fault;

class ForceDevice : public testing::TestWithParam<std::string> {
 protected:
  std::string file() const { return GetParam() == "openhaptics" ? "libHD.so" : "libdhd.so"; }
  void SetUp() override {
    ::setenv("GTDD_HOME", "/nonexistent", 1);
    got_ = &fake::device(file());
    from_ = got_->given;
  }
  void TearDown() override { got_->fault = Fault::none; }
  DeviceOptions options() const {
    DeviceOptions o;
    o.live.name = GetParam();
    o.live.library = fake::library(file());
    o.live.origin = Vec3::Zero();
    o.slots = std::make_shared<DeviceSlots>();
    return o;
  }
  std::unique_ptr<HapticDevice> open() {
    auto device = make_device(GetParam(), options());
    EXPECT_TRUE(becomes([&] { return health(*device) == DeviceHealth::ok; }));
    return device;
  }
  static DeviceHealth health(HapticDevice& device) {
    device.pose(0);
    return device.state().health;
  }
  fake::Given last() const { return got_->log[got_->given - 1]; }
  bool gets(const Vec3& f) const {
    const fake::Given now = last();
    return Vec3(now.f[0], now.f[1], now.f[2]) == f;
  }

  fake::Device* got_ = nullptr;
  std::size_t from_ = 0;
};
INSTANTIATE_TEST_SUITE_P(All, ForceDevice, testing::Values("openhaptics", "forcedimension"),
                         [](const auto& name) { return name.param; });

TEST_P(ForceDevice, ReadsInSiUnits) {
  got_->x[0] = 0.01;
  got_->x[1] = -0.02;
  got_->x[2] = 0.03;
  got_->buttons = 5;
  const auto device = open();
  EXPECT_TRUE(becomes([&] { return (device->pose(0).x - Vec3(0.01, -0.02, 0.03)).norm() < 1e-12; }));
  EXPECT_LT((device->pose(0).r * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12) << "columns are not rows";
  EXPECT_LT((device->state().v.value() - Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-12);
  EXPECT_EQ(device->state().buttons, 5u);
  EXPECT_TRUE(becomes([&] {
    device->pose(0);
    return device->state().delays > 0;
  }));
}

TEST_P(ForceDevice, GivesTheForceAlongItsOwnAxes) {
  DeviceOptions o = options();
  o.live.axes = "X-ZY";  // the world's y is the device's -z
  const auto device = make_device(GetParam(), o);
  EXPECT_TRUE(becomes([&] {
    device->write({.force = {1, 2, 3}}, 1e-3);
    return gets({1, 3, -2});
  }));
}

TEST_P(ForceDevice, AnOrderThatGrewOldWhileItHungIsNotGiven) {
  const auto device = open();
  EXPECT_TRUE(becomes([&] {
    device->write({.force = {0, 0, 1}}, 1e-3);
    return gets({0, 0, 1});
  }));
  const std::int64_t last_order = fake::now_ns();
  const std::size_t from = got_->given;
  got_->fault = Fault::hang;  // and nobody writes an order meanwhile
  EXPECT_TRUE(becomes([&] { return got_->fault == Fault::none; }));
  EXPECT_TRUE(becomes([&] { return got_->given > from + 5 && gets({0, 0, 0}); }));
  for (std::size_t i = from; i < got_->given; ++i)
    ASSERT_TRUE(got_->log[i].f[2] == 0 || got_->log[i].at_ns < last_order + 40'000'000) << "20 ms, and some to spare";
}

TEST_P(ForceDevice, SaysWhatItIs) {
  const DeviceInfo info = open()->info();
  EXPECT_TRUE(info.is_live && info.yields && info.gives_force && info.senses_turn);
  EXPECT_EQ(info.delay, 1e-3);
  if (GetParam() == "openhaptics") {
    EXPECT_EQ(info.name + info.serial, "Fake Touch220-1");
    EXPECT_EQ(info.max_force, 3.3);
    EXPECT_EQ(info.continuous_force, 0.88);
    EXPECT_NEAR(info.max_stiffness, 400, 1e-9);
    EXPECT_NEAR(info.max_damping, 4, 1e-9);
    EXPECT_NEAR(info.workspace_radius, 0.035, 1e-12);
    EXPECT_FALSE(info.gives_torque);
  } else {
    EXPECT_EQ(info.name + info.serial, "fake omega.64001");
    EXPECT_TRUE(std::isinf(info.max_force));
    EXPECT_TRUE(info.gives_torque);
  }
}

TEST_P(ForceDevice, NeedsNoHandWhereItKnowsItsPlaceAgain) {
  got_->fault = Fault::uncalibrated;
  const auto device = make_device(GetParam(), options());
  EXPECT_TRUE(becomes([&] { return health(*device) == DeviceHealth::uncalibrated; }));
  EXPECT_FALSE(calibration_advice(GetParam()).empty());
  const auto found = find_devices(GetParam(), options().live);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].trouble, "not calibrated: " + calibration_advice(GetParam()));
  got_->fault = Fault::none;
  EXPECT_TRUE(becomes([&] { return health(*device) == DeviceHealth::ok; }));
}

TEST_P(ForceDevice, CanBeOpenedAgainAndAgain) {
  for (int i = 0; i < 3; ++i) {
    const auto device = open();
    EXPECT_TRUE(got_->is_force_on);
  }
  EXPECT_FALSE(got_->is_force_on);
  if (GetParam() == "openhaptics") {
    EXPECT_LE(got_->opened, 1) << "never closed and opened again in one process";
    EXPECT_EQ(got_->closed, 0);
  } else {
    EXPECT_EQ(got_->closed, got_->opened);
  }
}

TEST_P(ForceDevice, IsFound) {
  const auto found = find_devices(GetParam(), options().live);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].backend, GetParam());
  EXPECT_EQ(found[0].trouble, "");
  EXPECT_EQ(found[0].name, GetParam() == "openhaptics" ? "Fake Touch 220-1" : "fake omega.6");
  EXPECT_EQ(found[0].id, GetParam() == "openhaptics" ? "" : "4001");
}

TEST_P(ForceDevice, ALibraryThatIsNotThereIsNamed) {
  DeviceOptions o = options();
  o.live.library = "/nowhere/" + file();
  const std::string expected = "tool.path.device: " + GetParam() + ": /nowhere/" + file() +
                               ": cannot open shared object file: No such file or directory; install the maker's "
                               "driver, or name its file in tool.path.device.library";
  EXPECT_EQ(message([&] { make_device(GetParam(), o); }), expected);
  const auto found = find_devices(GetParam(), o.live);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].trouble, expected);
}

TEST_P(ForceDevice, ALibraryWithoutTheFunctionsSaysWhich) {
  DeviceOptions o = options();
  o.live.library = fake::library("libempty.so");
  const std::string names = GetParam() == "openhaptics"
                                ? "hdInitDevice, hdDisableDevice, hdMakeCurrentDevice and 15 more"
                                : "dhdGetDeviceCount, dhdOpenID, dhdClose and 14 more";
  EXPECT_EQ(message([&] { make_device(GetParam(), o); }), "tool.path.device: " + GetParam() + ": " + o.live.library +
                                                              " is of another version: it has no " + names +
                                                              "; name another file in tool.path.device.library");
}

TEST(OpenHaptics, SeveralConfiguredDevicesAreNamed) {
  fake::device("libHD.so");
  const std::filesystem::path home = std::filesystem::temp_directory_path() / text("kt_gtdd_", getpid());
  std::filesystem::create_directories(home / "config");
  for (const char* name : {"Left Device", "Default Device"}) std::ofstream(home / "config" / text(name, ".config"));
  ::setenv("GTDD_HOME", home.c_str(), 1);
  DeviceOptions o;
  o.live.library = fake::library("libHD.so");
  EXPECT_EQ(message([&] { make_device("openhaptics", o); }),
            "tool.path.device: openhaptics: several are connected (Default Device, Left Device); name one in "
            "tool.path.device.id (--id)");
  ::setenv("GTDD_HOME", "/nonexistent", 1);
  std::filesystem::remove_all(home);
  o.live.id = "nobody";
  EXPECT_EQ(message([&] { make_device("openhaptics", o); }),
            "tool.path.device: openhaptics: \"nobody\" does not open (error 0x302, internal 0); is it connected, and "
            "set up with the maker's program?");
}

TEST(ForceDimension, SeveralAreNamedAndOneIsChosen) {
  fake::Device& two = fake::device("libdhd.so");
  two.count = 2;
  DeviceOptions o;
  o.live.library = fake::library("libdhd.so");
  EXPECT_EQ(
      message([&] { make_device("forcedimension", o); }),
      "tool.path.device: forcedimension: several are connected (4001, 4002); name one in tool.path.device.id (--id)");
  o.live.id = "17";
  EXPECT_EQ(message([&] { make_device("forcedimension", o); }),
            "tool.path.device.id \"17\": no such forcedimension device; found: 4001, 4002");
  o.live.id = "4002";
  EXPECT_EQ(make_device("forcedimension", o)->info().serial, "4002");
  two.count = 0;
  EXPECT_EQ(message([&] { make_device("forcedimension", o); }),
            "tool.path.device: forcedimension: no device is connected, or it may not be opened (the maker's rules for "
            "udev give the right to)");
  two.count = 1;
}

TEST(ForceDimension, ForcesThatTheControllerSwitchedOffAreAFault) {
  fake::Device& device = fake::device("libdhd.so");
  DeviceOptions o;
  o.live.library = fake::library("libdhd.so");
  const auto live = make_device("forcedimension", o);
  const auto health = [&] {
    live->pose(0);
    return live->state().health;
  };
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
  device.forces_off = 5;  // USB
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::gone; }));
  device.forces_off = 2;  // too fast: on again 0.2 s later
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::fault; }));
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
  device.forces_off = 6;  // the dead man's switch is not ours
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::fault; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  EXPECT_EQ(device.forces_off, 6);
}

TEST(ForceDimension, EachFlagOfTheStatusHasItsName) {
  fake::Device& device = fake::device("libdhd.so");
  DeviceOptions o;
  o.live.library = fake::library("libdhd.so");
  const auto live = make_device("forcedimension", o);
  const auto health = [&] {
    live->pose(0);
    return live->state().health;
  };
  for (const auto& [flag, expected] : {std::pair{0, DeviceHealth::unpowered}, std::pair{1, DeviceHealth::gone},
                                       std::pair{3, DeviceHealth::uncalibrated}, std::pair{9, DeviceHealth::fault},
                                       std::pair{12, DeviceHealth::uncalibrated}}) {
    EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
    device.wrong = flag;
    EXPECT_TRUE(becomes([&] { return health() == expected; })) << flag << ": " << name_of(health());
    device.wrong = -1;
  }
}

TEST(OpenHaptics, IsCalibratedInOneOfItsWaysAtATime) {
  fake::Device& device = fake::device("libHD.so");
  device.styles = 1 | 2 | 4;
  device.fault = Fault::uncalibrated;
  DeviceOptions o;
  o.live.library = fake::library("libHD.so");
  const auto live = make_device("openhaptics", o);
  const auto health = [&] {
    live->pose(0);
    return live->state().health;
  };
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::uncalibrated; }));
  device.fault = Fault::none;
  EXPECT_TRUE(becomes([&] { return health() == DeviceHealth::ok; }));
}

TEST(FindDevices, OfAnUnknownOrAPushedOneAreNone) {
  EXPECT_TRUE(find_devices("pushed", {}).empty());
  EXPECT_TRUE(find_devices("hend", {}).empty());
}

}  // namespace
}  // namespace kt
