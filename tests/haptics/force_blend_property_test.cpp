// The force across a refresh: by hand values, and that it never gives energy that was not put in.
#include "haptics/tick/force_blend.hpp"

#include <gtest/gtest.h>

#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kStep = 1e-3;

TEST(ForceBlend, FadesTheDifferenceInEqualStepsAfterFourTicks) {
  ForceBlend blend(kStep, 4 * kStep);
  const Vec3 down(0, 0, -1e-4), f(0, 0, 2);
  EXPECT_EQ(blend.apply(f, true, false, down), f);
  blend.begin();
  for (const double expected : {2.25, 2.4375, 2.578125, 2.68359375, 2.7890625, 2.89453125, 3.0, 3.0})
    EXPECT_NEAR(blend.apply({0, 0, 3}, true, false, down).z(), expected, 1e-15);
}

TEST(ForceBlend, IsNotMisledByTheFirstTicksOfAModel) {
  ForceBlend blend(kStep, 12 * kStep);
  const Vec3 down(0, 0, -1e-4);
  double last = blend.apply({0, 0, 2}, true, false, down).z(), largest = 0;
  blend.begin();
  for (const double force : {1.4, 1.7, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0}) {  // it takes two ticks to find its balance
    const double now = blend.apply({0, 0, force}, true, false, down).z();
    largest = std::max(largest, std::abs(now - last));
    last = now;
  }
  EXPECT_LT(largest, 0.06);  // the difference of its first tick alone would be felt as 0.25
}

TEST(ForceBlend, FadesAtOnceTheDifferenceToAModelThatWasRunIn) {
  ForceBlend blend(kStep, 4 * kStep);
  const Vec3 down(0, 0, -1e-4);
  blend.apply({0, 0, 2}, true, false, down);
  blend.begin(Vec3(0, 0, 2.8));  // of the new model in that tick; its force rises by 0.2 in each
  double force = 2.8;
  for (const double expected : {2.4, 2.8, 3.2, 3.6, 3.8}) {
    force += 0.2;
    EXPECT_NEAR(blend.apply({0, 0, force}, true, false, down).z(), expected, 1e-14);
  }
}

TEST(ForceBlend, LeavesTheStartAndTheEndOfContactAlone) {
  ForceBlend blend(kStep, 0.01);
  const Vec3 down(0, 0, -1e-4), f(0, 0, 2);
  blend.apply(Vec3::Zero(), false, false, down);
  blend.begin();  // touched for the first time just now
  EXPECT_EQ(blend.apply(f, true, false, down), f);
  blend.begin();
  EXPECT_GT((blend.apply(2 * f, true, false, down) - 2 * f).norm(), 0);
  EXPECT_EQ(blend.apply(Vec3::Zero(), false, false, down), Vec3(Vec3::Zero()));
}

TEST(ForceBlend, FadesOutWhereContactIsLostAtTheEdgeOfThePatchAndBackIn) {
  ForceBlend blend(kStep, 10 * kStep);
  const Vec3 along(1e-4, 0, 0), f(0, 0, 2);
  Vec3 last = blend.apply(f, true, false, along);
  for (int i = 0; i < 15; ++i) {
    const Vec3 out = blend.apply(Vec3::Zero(), false, true, along);
    EXPECT_NEAR(out.z(), std::max(0.0, 2 - 0.2 * (i + 1)), 1e-14);
    last = out;
  }
  EXPECT_NEAR(blend.apply(f, true, false, along).z(), 0.2, 1e-14);
}

TEST(ForceBlend, GivesNoEnergyThatWasNotPutIn) {
  int pushed = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    ForceBlend blend(kStep, 0.02);
    double work = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 r = random_vector(3, 1000 * seed + static_cast<unsigned>(i));
      const Vec3 force = random_vector(3, 1000 * seed + static_cast<unsigned>(i / 25) + 7), moved = 1e-3 * r;
      if (i % 25 == 0) blend.begin();
      const double before = work;
      const Vec3 out = blend.apply(force, true, false, moved);
      work -= out.dot(moved);
      const double own = -force.dot(moved);
      if (work < 0) {
        EXPECT_GE(work - before, own - 1e-12) << "seed " << seed << " tick " << i;
      }
      pushed += work < 0;
    }
  }
  EXPECT_GT(pushed, 100) << "the limit was never met";
}

}  // namespace
}  // namespace kt
