// The spring between device and tool: what is felt, and that nothing swings by itself.
#include "haptics/safety/device_coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/console/allocation_counter.hpp"
#include "haptics/device/hand_loop.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr double kMillisecond = 1e-3;

/// Half space below z = 0 with Coulomb friction: a spring to where the tool first touched, which slides along.
class Ground {
 public:
  explicit Ground(double stiffness, double mu = 0) : stiffness_(stiffness), mu_(mu) {}
  Vec3 force(const Vec3& x) {
    if (!(x.z() < 0)) {
      held_ = false;
      return Vec3::Zero();
    }
    if (!held_) at_ = Vec3(x.x(), x.y(), 0);
    held_ = true;
    const double normal = -stiffness_ * x.z();
    Vec3 tangent = stiffness_ * Vec3(at_.x() - x.x(), at_.y() - x.y(), 0);
    if (const double size = tangent.norm(); size > mu_ * normal) {
      tangent *= mu_ * normal / size;
      at_ = Vec3(x.x(), x.y(), 0) + tangent / stiffness_;
    }
    return tangent + Vec3(0, 0, normal);
  }

 private:
  double stiffness_, mu_;
  Vec3 at_ = Vec3::Zero();
  bool held_ = false;
};

TEST(DeviceCoupling, AWallIsFeltInSeriesWithItWhateverItsStiffness) {
  constexpr double kCoupling = 500, kDepth = 2e-3;
  for (const double damping : {0.0, 0.05})
    for (double wall = 10; wall <= 1e7; wall *= 3) {
      DeviceCoupling coupling({kCoupling, damping});
      Ground ground(wall);
      Vec3 force = Vec3::Zero(), tool = Vec3::Zero();
      double least = 1, most = 0;
      for (int i = 0; i < 400; ++i) {
        const double z = 1e-3 - std::min(5e-5 * i, 1e-3 + kDepth);
        tool = coupling.tool({0, 0, z}, kMillisecond);
        force = coupling.force(ground.force(tool));
        if (i < 300) continue;
        least = std::min(least, force.z());
        most = std::max(most, force.z());
      }
      const double felt = wall * kCoupling / (wall + kCoupling);
      EXPECT_NEAR(force.z(), felt * kDepth, 1e-6 * felt * kDepth) << wall;
      EXPECT_NEAR(felt_stiffness(wall, kCoupling), felt, 1e-12 * felt);
      EXPECT_LT(most - least, 1e-6 * most) << "at rest: " << wall;
      EXPECT_NEAR(wall * -tool.z(), force.z(), 1e-5 * force.z()) << "balance at the tool";
    }
}

TEST(DeviceCoupling, WithoutContactTheToolIsTheDevice) {
  Sample s{std::mt19937_64(1)};
  DeviceCoupling coupling({700, 0.1});
  Ground ground(2e4);
  Vec3 x(0, 0, 0.01);
  for (int i = 0; i < 3000; ++i) {
    // Dips into the ground now and then.
    x = Vec3(1e-3 * s.uniform(-1, 1), 0, 4e-3 * std::cos(0.02 * i) + 2e-3);
    const Vec3 tool = coupling.tool(x, kMillisecond);
    const Vec3 body = ground.force(tool);
    const Vec3 force = coupling.force(body);
    if (body.isZero(0)) {
      EXPECT_TRUE(force.isZero(0));
    }
    if (x.z() > 1e-3) {
      EXPECT_EQ(tool, x);
    }
  }
}

TEST(DeviceCoupling, NoForceIsStifferThanItInAnyTickOnceThereIsContact) {
  Sample s{std::mt19937_64(2)};
  for (int run = 0; run < 20; ++run) {
    const double k = s.uniform(50, 2000), wall = std::pow(10, s.uniform(1, 6));
    DeviceCoupling coupling({k});
    Ground ground(wall);
    double z = 1e-3, target = -2e-3;
    for (int i = 0; i < 3000; ++i) {
      if (i % 50 == 0) target = s.uniform(-4e-3, -1e-3);
      z += 0.03 * (target - z);
      const Vec3 tool = coupling.tool({0, 0, z}, kMillisecond);
      const Vec3 force = coupling.force(ground.force(tool));
      // Never beyond the spring's force for the device's whole depth, nor the series' by more than the body is late.
      EXPECT_LE(force.z(), k * std::max(0.0, -z) + 1e-12) << wall << ' ' << i;
      if (i > 100) {
        EXPECT_NEAR(force.z(), felt_stiffness(wall, k) * -z, 0.1 * k * 4e-3) << wall << ' ' << i;
      }
    }
  }
}

TEST(DeviceCoupling, ASlidingToolIsNotDragged) {
  constexpr double kCoupling = 300, kMu = 0.3, kSpeed = 0.1;
  for (const auto& [wall, normal_is_known] : {std::pair{300.0, false}, {3000.0, false}, {3000.0, true}, {3e4, true}}) {
    DeviceCoupling coupling({kCoupling});
    Ground ground(wall, kMu);
    Vec3 force, tool, x;
    for (int i = 0; i < 1500; ++i) {
      x = Vec3(i > 200 ? kSpeed * kMillisecond * (i - 200) : 0, 0, std::max(-2e-3, 1e-3 - 2e-5 * i));
      tool = coupling.tool(x, kMillisecond);
      force = coupling.force(ground.force(tool), normal_is_known ? Vec3(0, 0, 1) : Vec3(0, 0, 0));
      if (i < 600) continue;
      EXPECT_NEAR(force.x(), -kMu * force.z(), 0.03 * kMu * force.z()) << "Coulomb's, no more: " << wall;
      EXPECT_NEAR(x.x() - tool.x(), kMu * force.z() / kCoupling, 0.03 * kMu * force.z() / kCoupling);
    }
  }
}

TEST(DeviceCoupling, ABodyThatComesToAStillToolPushesTheDeviceNoFasterThanItComes) {
  DeviceCoupling coupling({200});
  double before = 0;
  for (int i = 0; i < 300; ++i) {
    const double surface = std::min(2e-3, 1e-5 * i) - 5e-4;  // rises at 10 mm/s to a device at 0
    const Vec3 tool = coupling.tool(Vec3::Zero(), kMillisecond);
    const Vec3 force = coupling.force({0, 0, 2e4 * std::max(0.0, surface - tool.z())});
    // 0.1 m/s is what it may stretch by; contact that is lost and found in neighbouring ticks counts twice.
    EXPECT_LE(std::abs(force.z() - before), 200 * 2e-4) << i;
    before = force.z();
  }
  EXPECT_NEAR(before, felt_stiffness(2e4, 200) * 1.5e-3, 1e-3);
}

TEST(DeviceCoupling, IsChosenFromWhatIsKnown) {
  EXPECT_NEAR(coupling_stiffness(1, 0, kMillisecond, 0.8e-3), 0.8 / 1.3e-3, 1e-9);
  EXPECT_EQ(coupling_stiffness(1, 400, kMillisecond, 0.8e-3), 400) << "the device's own if that is less";
  EXPECT_EQ(coupling_stiffness(0, 400, kMillisecond, 0.8e-3), 400);
  EXPECT_EQ(coupling_stiffness(0, 0, kMillisecond, 0.8e-3), kUnknownStiffness);
  DeviceCoupling none({});
  EXPECT_EQ(none.tool({1, 2, 3}, kMillisecond), Vec3(1, 2, 3));
  EXPECT_EQ(none.force({0, 0, 5}), Vec3(0, 0, 5)) << "without one the body's force is the device's";
}

TEST(DeviceCoupling, SoftensWhileTheDeviceSwingsAndNotForAHandThatMoves) {
  const auto stiffness_after = [](double hz, double size, bool adapts) {
    DeviceCoupling coupling({.stiffness = 800, .adapts = adapts});
    Ground ground(5000);
    for (int i = 0; i < 1500; ++i) {
      const Vec3 x(0, 0, -3e-3 + size * std::sin(2 * 3.14159265358979 * hz * i * kMillisecond));
      coupling.force(ground.force(coupling.tool(x, kMillisecond)));
    }
    return coupling.stiffness();
  };
  EXPECT_LE(stiffness_after(15, 1e-3, true), 400) << "a swing of 15 Hz that goes on";
  EXPECT_EQ(stiffness_after(4, 2e-3, true), 800) << "a hand that presses four times a second";
  EXPECT_EQ(stiffness_after(15, 3e-5, true), 800) << "the tremor of a hand";
  EXPECT_EQ(stiffness_after(15, 1e-3, false), 800);
}

TEST(DeviceCoupling, DoesNotAllocate) {
  DeviceCoupling coupling({300, 0.01, true});
  Ground ground(3000, 0.2);
  const long long before = thread_allocations();
  for (int i = 0; i < 1000; ++i) {
    const Vec3 x(1e-4 * i, 0, -2e-3 * std::sin(0.1 * i));
    coupling.force(ground.force(coupling.tool(x, kMillisecond)));
  }
  EXPECT_EQ(thread_allocations(), before);
}

}  // namespace
}  // namespace kt
