// Times at which features come within a distance, against distances in 113-bit arithmetic.
#include "collision/offset_toi.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random_sample.hpp"
#include "tests/support/toi_oracle.hpp"

namespace kt {
namespace {

struct Motion {
  Vec3 t0[4], t1[4];
};

OffsetToi toi_of(bool is_face, const Motion& m, double distance) {
  return is_face ? vertex_face_offset_toi(m.t0, m.t1, distance) : edge_edge_offset_toi(m.t0, m.t1, distance);
}
double gap(bool is_face, const Motion& m, double t) { return feature_distance(is_face, m.t0, m.t1, t); }

// Coordinates and speeds of about 1, distances of 0.01 .. 0.3: the condition's terms are squares and sixth powers of
// these, wrong by some 100 u, over twice the distance.
constexpr double kRoundoff = 1e-10;

TEST(OffsetToi, IsNotLateAndTheDistanceIsReachedThere) {
  Sample s{std::mt19937_64(51)};
  int hits = 0, grazes = 0;
  double largest_gap = 0;
  for (int i = 0; i < 4000; ++i) {
    const bool is_face = i % 2 == 0;
    Motion m;
    const double motion = i % 3 == 0 ? 0.3 : 1.5, radius = s.uniform(0.01, 0.3);
    const Vec3 way = motion * s.cube();
    for (int k = 0; k < 4; ++k) m.t0[k] = s.cube();
    if (i % 5 == 0) m.t0[3] = m.t0[2] + 0.5 * (m.t0[2] - m.t0[1]);  // without area; of edges, anything
    for (int k = 0; k < 4; ++k) m.t1[k] = m.t0[k] + (k == 0 || (!is_face && k == 1) ? way : 0.2 * motion * s.cube());
    const OffsetToi r = toi_of(is_face, m, radius);
    ASSERT_NE(r.status, OffsetToi::Status::invalid_input);
    ASSERT_NE(r.status, OffsetToi::Status::budget_exhausted);
    // Not late: at no time before is it nearer.
    const double until = r.is_contact() ? r.toi : 1;
    for (int k = 0; k < 64 && until > 0; ++k) ASSERT_GE(gap(is_face, m, until * k / 64), radius) << i << " " << k;
    if (!r.is_contact()) {
      ASSERT_GT(gap(is_face, m, 1), radius);
      continue;
    }
    ++hits;
    if (r.toi == 0) continue;
    ASSERT_LE(gap(is_face, m, r.toi), radius + kRoundoff) << i;
    largest_gap = std::max(largest_gap, gap(is_face, m, r.toi) - radius);
    grazes += gap(is_face, m, std::min(1.0, r.toi + 1e-6)) > radius;
  }
  std::printf("%d hits, %d of them graze, further than the distance by at most %.2g\n", hits, grazes, largest_gap);
  EXPECT_GT(hits, 500);
}

TEST(OffsetToi, ASphereMeetsFaceEdgeAndVertexWhenItShould) {
  const Vec3 face[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const auto drop = [&](double x, double y, double radius) {
    const Vec3 t0[4] = {{x, y, 2}, face[0], face[1], face[2]}, t1[4] = {{x, y, -2}, face[0], face[1], face[2]};
    return vertex_face_offset_toi(t0, t1, radius);
  };
  const double tolerance = 1e-12;
  EXPECT_NEAR(drop(0.25, 0.25, 1).toi, 0.25, tolerance);
  EXPECT_NEAR(drop(0.5, -0.6, 1).toi, (2 - 0.8) / 4, tolerance);  // an edge, 0.6 beside it
  EXPECT_NEAR(drop(-0.36, -0.48, 1).toi, 0.3, tolerance);         // a vertex, 0.6 beside it
  EXPECT_FALSE(drop(0.5, -1.0001, 1).is_contact());
  EXPECT_TRUE(drop(0.5, -1, 1).is_contact());  // touches at t = 1/2
  EXPECT_EQ(drop(0.25, 0.25, 2).status, OffsetToi::Status::already_inside);
}

TEST(OffsetToi, CapsulesMeetAlongsideAcrossAndEndToEnd) {
  const auto drop = [](const Vec3& a0, const Vec3& a1) {
    const Vec3 down(0, 0, -4), t0[4] = {a0, a1, {-1, 0, 0}, {1, 0, 0}}, t1[4] = {a0 + down, a1 + down, t0[2], t0[3]};
    return edge_edge_offset_toi(t0, t1, 1);
  };
  const double tolerance = 1e-12;
  EXPECT_NEAR(drop({0, -1, 2}, {0, 1, 2}).toi, 0.25, tolerance);
  // Where the normal vanishes the distance is enlarged by 2^-21.
  const double parallel = 1e-6;
  EXPECT_NEAR(drop({-3, 0, 2}, {3, 0, 2}).toi, 0.25, parallel);
  EXPECT_NEAR(drop({-3, 0.6, 2}, {3, 0.6, 2}).toi, 0.3, parallel);
  EXPECT_NEAR(drop({1.6, 0, 2}, {3, 0, 2}).toi, 0.3, tolerance);
  EXPECT_FALSE(drop({2.001, 0, 2}, {3, 0, 2}).is_contact());
  EXPECT_NEAR(drop({0.5, 0, 2}, {0.5, 0, 2}).toi, 0.25, parallel);  // an edge without length
  EXPECT_FALSE(drop({2.5, 0, 2}, {2.5, 0, 2}).is_contact());
}

TEST(OffsetToi, WhatIsNoNumberIsInvalid) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1, 1e40};
  Motion m;
  for (int k = 0; k < 4; ++k) m.t0[k] = m.t1[k] = Vec3(k == 1, k == 2, k == 3);
  for (const double distance : bad)
    for (const bool is_face : {true, false})
      EXPECT_EQ(toi_of(is_face, m, distance).status, OffsetToi::Status::invalid_input);
  m.t1[3][1] = bad[0];
  EXPECT_EQ(toi_of(true, m, 1).status, OffsetToi::Status::invalid_input);
}

}  // namespace
}  // namespace kt
