// The next root of a cubic: never skipped, and found as closely as the coefficients are known.
#include "collision/impact/bernstein.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/random_sample.hpp"

namespace kt::bernstein {
namespace {

/// a (t - r0) (t - r1) (t - r2), in Bernstein form.
Cubic with_roots(double a, const double (&r)[3], double error) {
  const double c0 = -r[0] * r[1] * r[2], c1 = r[0] * r[1] + r[1] * r[2] + r[2] * r[0], c2 = -r[0] - r[1] - r[2];
  return make_cubic(a * c0, a * (c0 + c1 / 3), a * (c0 + 2 * c1 / 3 + c2 / 3), a * (c0 + c1 + c2 + 1),
                    error + 1e-15 * std::abs(a), false);
}

TEST(NextZero, IsBeforeEveryRootAndCloseToTheNext) {
  Sample s{std::mt19937_64(41)};
  int found = 0;
  double earliest = 0;
  for (int i = 0; i < 200000; ++i) {
    double r[3] = {s.uniform(-1, 2), s.uniform(-1, 2), s.uniform(-1, 2)};
    const bool is_double = i % 7 == 0;
    if (is_double) r[1] = r[2];
    std::sort(r, r + 3);
    const Cubic c = with_roots(s.uniform(0, 1) < 0.5 ? -3 : 0.1, r, i % 3 == 0 ? 1e-12 : 0);
    const double from = i % 2 == 0 ? 0 : s.uniform(0, 1);
    const double next = next_zero(c, from);
    const auto* root = std::find_if(r, r + 3, [&](double t) { return t >= from; });
    const double truth = root == r + 3 || *root > 1 ? kNever : *root;
    ASSERT_LE(next, truth);
    ASSERT_GE(next, from);
    ASSERT_TRUE(next <= 1 || next == kNever);
    if (next > 1 || truth > 1) continue;
    ++found;
    const double slope_at_root = std::abs(slope(c, truth)), distance = truth - next;
    // Along a straight line by twice the error; never by more than a root of multiplicity two or three allows.
    if (slope_at_root > 1e-3 * largest_coefficient(c)) {
      earliest = std::max(earliest, distance * slope_at_root / c.error);
    }
    ASSERT_LT(distance, 1e-3);
  }
  std::printf("%d roots, early by up to %.2g errors\n", found, earliest);
  EXPECT_LT(earliest, 5);
  EXPECT_GT(found, 50000);
}

TEST(NextZero, CoefficientsOfOneSignHaveNone) {
  Sample s{std::mt19937_64(42)};
  for (int i = 0; i < 10000; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    const Cubic c = make_cubic(sign * s.uniform(1e-9, 1), sign * s.uniform(1e-9, 1), sign * s.uniform(1e-9, 1),
                               sign * s.uniform(1e-9, 1), 0, false);
    EXPECT_EQ(next_zero(c, 0), kNever);
    EXPECT_EQ(next_zero(c, s.uniform(0, 1)), kNever);
  }
}

TEST(NextZero, WhatIsZeroWithinItsErrorIsNotSkipped) {
  EXPECT_EQ(next_zero(make_cubic(0, 0, 0, 0, 0, true), 0), 0);
  EXPECT_EQ(next_zero(make_cubic(0, 0, 0, 0, 0, true), 0.3), 0.3);
  EXPECT_EQ(next_zero(make_cubic(1, 1, 1, 1, 2, true), 0.5), 0.5);
  EXPECT_EQ(next_zero(make_cubic(0, 1, 1, 1, 0, true), 0), 0);
  // (t - 1/2)^2: it touches zero, and 1e-9 above it does not.
  const double touch = next_zero(make_cubic(0.25, -0.25 / 3, -0.25 / 3, 0.25, 0, false), 0);
  EXPECT_LE(touch, 0.5);
  EXPECT_GT(touch, 0.5 - 1e-7);
  EXPECT_EQ(next_zero(make_cubic(0.25 + 1e-9, -0.25 / 3 + 1e-9, -0.25 / 3 + 1e-9, 0.25 + 1e-9, 0, false), 0), kNever);
}

}  // namespace
}  // namespace kt::bernstein
