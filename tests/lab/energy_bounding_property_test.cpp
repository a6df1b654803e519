// Energy bounding at a wall without friction: what is felt, and that nothing swings by itself.
#include "lab/stability/runs/energy_bounding.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace kt {
namespace {

constexpr double kMillisecond = 1e-3;

TEST(EnergyBounding, IsAWallOfTheStiffnessThatTheDeviceHolds) {
  constexpr double kDelay = 1e-3, kDamping = 0.6;
  const double bound = kDamping / (0.5 * kMillisecond + kDelay);
  for (const double wall : {0.2 * bound, 0.9 * bound, 2 * bound, 50 * bound}) {
    EnergyBounding bounding(kDamping, kMillisecond, kDelay);
    double in = 0, z = 5e-4, force = 0, given = 0;
    for (int i = 0; i < 1200; ++i) {
      const double next = i < 500 ? 5e-4 - 5e-6 * i : i < 700 ? z : z + 5e-6;
      given += force * (next - z);
      z = next;
      force = bounding.tick({0, 0, z}, {0, 0, -wall * std::min(z, 0.0)}).z();
      if (i == 499) in = force;
      if (i == 650) {
        EXPECT_NEAR(force, in, 1e-12) << "held: the hand is still";
      }
    }
    EXPECT_NEAR(in, std::min(wall, bound) * 1.995e-3, 0.01 * in) << wall / bound;
    EXPECT_EQ(force, 0) << "out again";
    EXPECT_LE(given, 1.01 * 0.5 * std::min(wall, bound) * 2e-3 * 5e-6 * 2) << "no more comes back than a tick's hold";
  }
}

TEST(EnergyBounding, LetsGoOfABodyThatIsNoLongerThere) {
  EnergyBounding bounding(1, kMillisecond, 0);
  double force = 0;
  for (int i = 0; i < 100; ++i) force = bounding.tick({0, 0, -1e-5 * i}, {0, 0, 1e3 * 1e-5 * i}).z();
  EXPECT_GT(force, 0.5);
  for (int i = 0; i < 400; ++i) force = bounding.tick({0, 0, -99e-5}, Vec3::Zero()).z();
  EXPECT_LT(force, 1e-3);
}

}  // namespace
}  // namespace kt
