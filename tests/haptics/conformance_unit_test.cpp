// What every entry of the haptics tables must do, whoever adds it: contact_solver.def, device.def, link.def.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "haptics/device/device_backends.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/link/links.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/haptics_body.hpp"

namespace kt {
namespace {

void expect_well_formed(const std::vector<BackendInfo>& table) {
  std::set<std::string> names;
  for (const BackendInfo& b : table) {
    EXPECT_TRUE(names.insert(b.name).second) << b.name << " is listed twice";
    EXPECT_FALSE(b.what.empty()) << b.name;
    EXPECT_TRUE(b.available || !b.option.empty()) << b.name << " must say how to turn it on";
  }
  EXPECT_FALSE(names.empty());
}

TEST(Tables, AreWellFormed) {
  expect_well_formed(contact_solver_backends());
  expect_well_formed(device_backends());
  expect_well_formed(link_backends());
}

std::vector<std::string> available(const std::vector<BackendInfo>& table) {
  std::vector<std::string> out;
  for (const BackendInfo& b : table)
    if (b.available) out.push_back(b.name);
  return out;
}
const auto kName = [](const auto& name) { return name.param; };

class Law : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, Law, testing::ValuesIn(available(contact_solver_backends())), kName);

ContactProblem pushed(double f_t) {
  ContactProblem p;
  p.count = 1;
  p.h = 1e-3;
  p.normal[0] = Vec3::UnitZ();
  p.velocity = Vec3(f_t, 0, 1);  // the body comes up into the tool
  p.W = Mat3::Identity();
  p.inertia = Mat3::Identity();
  p.force = Vec3(f_t, 0, 1);
  return p;
}

TEST_P(Law, PushesTheToolOutAndNeverPullsIt) {
  const auto solver = make_contact_solver(GetParam(), {0.5, 0.5});
  for (double f_t : {-3.0, -0.1, 0.0, 0.2, 5.0}) {
    ContactSolution s;
    solver->solve(pushed(f_t), s);
    EXPECT_GT(s.force_on_tool.z(), 0);
    EXPECT_NE(s.mode[0], ContactMode::free);
    ContactProblem leaving = pushed(f_t);
    leaving.velocity.z() = leaving.force.z() = -1;
    solver->solve(leaving, s);
    EXPECT_EQ(s.mode[0], ContactMode::free);
    EXPECT_TRUE(s.force_on_tool.isZero(0) && s.impulse.isZero(0) && s.inertial_impulse.isZero(0));
  }
}

TEST_P(Law, IsTheSameFromEveryDirection) {
  const auto solver = make_contact_solver(GetParam(), {0.5, 0.5});
  ContactSolution one, turned;
  solver->solve(pushed(2), one);
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  ContactProblem p = pushed(2);
  p.normal[0] = R * p.normal[0];
  p.velocity = R * Vec3(p.velocity);
  p.force = R * p.force;
  solver->solve(p, turned);
  EXPECT_EQ(one.mode[0], turned.mode[0]);
  EXPECT_LT((turned.force_on_tool - R * one.force_on_tool).norm(), 1e-9 * one.force_on_tool.norm());
}

TEST_P(Law, SolvesWithoutMemoryOfItsOwn) {
  const auto solver = make_contact_solver(GetParam(), {0.5, 0.5});
  const ContactProblem a = pushed(2), b = pushed(-0.3);
  ContactSolution first, again;
  EXPECT_EQ(allocations_during([&] { solver->solve(a, first); }), 0);
  ContactSolution other;
  solver->solve(b, other);
  solver->solve(a, again);
  EXPECT_EQ(first.force_on_tool, again.force_on_tool);
}

TEST_P(Law, PressesAndDragsOnABody) {
  const bool geometric = make_contact_solver(GetParam(), {0.5, 0.5})->deformation() != Deformation::none;
  const SoftBlock body{
      SoftBlockOptions{.young = geometric ? 1000.0 : 1e4,
                       .scheme = geometric ? LocalScheme::symplectic_euler : LocalScheme::implicit_euler,
                       .metric = geometric ? Metric::identity : Metric::implicit,
                       .reach = 0.02}};
  const Vec3 start(0.04, 0.025, 0.021);
  Press press(body, kPointTool, GetParam(), {0.5, 0.5}, start);
  double force = 0;
  const auto look = [&](const LocalFrame& f) {
    ASSERT_TRUE(f.force.allFinite());
    force = std::max(force, f.f_n);
  };
  press.move(start - Vec3(0, 0, 0.002), 100, look);
  press.move(start + Vec3(0.005, 0, -0.002), 200, look);
  EXPECT_GT(force, 1e-3);
  press.move(start + Vec3(0.005, 0, 0.005), 100, look);
  EXPECT_TRUE(press.go_to(press.tool()).force.isZero(0));
}

TEST(LawNames, UnknownOnesNameTheKnown) {
  try {
    make_contact_solver("coulom", {0.5, 0.5});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("coulomb"), std::string::npos);
  }
  EXPECT_THROW(make_contact_solver("coulomb", {0.3, 0.5}), InputError) << "kinetic above static";
  EXPECT_THROW(make_contact_solver("coulomb", {0.3, -0.1}), InputError);
  EXPECT_THROW(make_contact_solver("coulomb", {NAN, NAN}), InputError);
}

class Device : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<HapticDevice> make() {
    DeviceOptions o;
    o.path = {{0, {1, 2, 3}}, {1, {1.5, 2, 3}}};
    o.recording = file_;
    return make_device(GetParam(), o);
  }
  void SetUp() override {
    std::ofstream out(file_);
    for (int i = 0; i <= 1000; ++i) out << i * 1e-3 << ',' << 1 + 0.0005 * i << ",2,3\n";
  }
  void TearDown() override { std::filesystem::remove(file_); }
  const std::string file_ =
      (std::filesystem::temp_directory_path() / ("kt_device_" + GetParam() + std::to_string(::getpid()) + ".csv"))
          .string();
};
/// Without those outside the program: tests/driver/ has what stands for them.
std::vector<BackendInfo> simulated_devices() {
  std::vector<BackendInfo> out = device_backends();
  const std::vector<BackendInfo> live = live_device_backends();
  std::erase_if(out, [&](const BackendInfo& b) { return std::ranges::find(live, b) != live.end(); });
  return out;
}
INSTANTIATE_TEST_SUITE_P(All, Device, testing::ValuesIn(available(simulated_devices())), kName);

TEST_P(Device, StartsOnItsPathAndKeepsBelowItsSpeed) {
  const auto device = make();
  EXPECT_LT((device->pose(0).x - Vec3(1, 2, 3)).norm(), 1e-5);
  EXPECT_GT(device->info().max_force, 0);
  Vec3 before = device->pose(0).x;
  for (int i = 1; i <= 1000; ++i) {
    device->write({.force = Vec3::Zero()}, 1e-3);
    const Vec3 now = device->pose(i * 1e-3).x;
    ASSERT_TRUE(now.allFinite());
    ASSERT_LE((now - before).norm(), device->max_speed() * 1e-3 + 1e-5) << "tick " << i;
    before = now;
  }
  EXPECT_LT((before - Vec3(1.5, 2, 3)).norm(), 1e-3);
}

TEST_P(Device, TicksWithoutAllocatingAndRepeatsItself) {
  const auto one = make(), two = make();
  for (int i = 0; i <= 500; ++i) {
    const Vec3 force(0.1, -0.2, 0.001 * i);
    const auto allocations = allocations_during([&] {
      one->pose(i * 1e-3).x;
      one->write({.force = force}, 1e-3);
    });
    ASSERT_EQ(allocations, 0);
    two->write({.force = force}, 1e-3);
    ASSERT_EQ(one->pose(i * 1e-3).x, two->pose(i * 1e-3).x);
  }
}

TEST(DeviceNames, UnknownOnesNameTheKnown) {
  try {
    make_device("hend", {});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("hand"), std::string::npos);
  }
}

}  // namespace
}  // namespace kt
