#include "lab/study/paper_claims.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

std::vector<LocalFrame> drag(int ticks, double f_n, double f_t) {
  std::vector<LocalFrame> out(static_cast<std::size_t>(ticks));
  for (int i = 0; i < ticks; ++i) {
    LocalFrame& f = out[static_cast<std::size_t>(i)];
    f.t = 1e-3 * (i + 1);
    f.f_n = f_n;
    f.f_t = f_t;
    f.mode = ContactMode::stick;
  }
  return out;
}

TEST(PaperClaims, FrictionAboveTheNormalForceIsCountedWhereTheToolPresses) {
  EXPECT_EQ(share_above_normal(drag(100, 0.01, 0.03), 0), 1);
  EXPECT_EQ(share_above_normal(drag(100, 0.01, 0.009), 0), 0);
  auto half = drag(100, 0.01, 0.03);
  for (int i = 0; i < 50; ++i) half[static_cast<std::size_t>(i)].f_t = 0.005;
  EXPECT_EQ(share_above_normal(half, 0), 0.5);
  EXPECT_EQ(share_above_normal(half, 0.0505), 1);  // the press is left out
}

/// A single tick whose normal force is next to nothing made a ratio of any size.
TEST(PaperClaims, ANormalForceThatVanishesShowsNothing) {
  auto frames = drag(100, 0.01, 0.001);
  frames[50].f_n = 1e-15;
  EXPECT_EQ(share_above_normal(frames, 0), 0);
  EXPECT_EQ(share_above_normal(drag(100, 0, 0.03), 0), 0);
}

TEST(PaperClaims, ADropAfterSticking) {
  auto frames = drag(40, 0.01, 0.02);
  for (std::size_t i = 20; i < 40; ++i) {
    frames[i].mode = ContactMode::frictional_slide;
    frames[i].f_t = 0.015;
  }
  EXPECT_EQ(stick_to_slip(frames), 1);
  EXPECT_NEAR(largest_slip_drop(frames, 0), 0.25, 1e-12);
}

}  // namespace
}  // namespace kt
