// What a time of impact must be at any scale, place and order of the vertices: nothing that touches is missed, and the
// bits do not depend on how the features are numbered.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

#include "collision/impact/feature_toi.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr ToiMode kModes[] = {ToiMode::conservative, ToiMode::exact};

struct Motion {
  Vec3 t0[4], t1[4];
};

/// Whole numbers of which sums and products with eighths stay whole numbers below 2^40: nothing here rounds.
struct Grid {
  std::mt19937_64 random;
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }
  Vec3 vector(int range) { return Vec3(integer(-range, range), integer(-range, range), integer(-range, range)); }
};

/// x at eighth k / 8 of the step and its way per eighth.
void move(Motion& m, int i, const Vec3& x, const Vec3& way, int k) {
  m.t0[i] = x - k * way;
  m.t1[i] = x + (8 - k) * way;
}

/// All four points at eighth k, such that they touch there; zeros: how many weights of each feature vanish.
Motion touching(Grid& g, bool is_face, int zeros, int k) {
  const int range = 1 << g.integer(1, 8);
  const Vec3 b = 8 * g.vector(range), c = 8 * g.vector(range), d = 8 * g.vector(range);
  Motion m;
  const auto way = [&] { return g.integer(0, 9) == 0 ? Vec3(Vec3::Zero()) : g.vector(1 << g.integer(0, 8)); };
  if (is_face) {
    int w[3] = {8, 0, 0};
    if (zeros < 2) w[0] = g.integer(1, 7), w[1] = 8 - w[0];
    if (zeros < 1) w[0] = g.integer(1, 6), w[1] = g.integer(1, 7 - w[0]), w[2] = 8 - w[0] - w[1];
    std::shuffle(w, w + 3, g.random);
    move(m, 0, (w[0] * b + w[1] * c + w[2] * d) / 8, way(), k);
    move(m, 1, b, way(), k), move(m, 2, c, way(), k), move(m, 3, d, way(), k);
    return m;
  }
  const int s = zeros > 0 ? 8 * g.integer(0, 1) : g.integer(1, 7),
            r = zeros > 1 ? 8 * g.integer(0, 1) : g.integer(1, 7);
  // Edge a through the point of edge b: a0 = p - s e, a1 = p + (8 - s) e.
  const Vec3 p = ((8 - r) * b + r * c) / 8, e = d / 8;
  move(m, 0, p - s * e, way(), k), move(m, 1, p + (8 - s) * e, way(), k);
  move(m, 2, b, way(), k), move(m, 3, c, way(), k);
  return m;
}

Motion placed(const Motion& m, double scale, const Vec3& offset) {
  Motion out;
  for (int i = 0; i < 4; ++i) {
    out.t0[i] = scale * (m.t0[i] + offset);
    out.t1[i] = scale * (m.t1[i] + offset);
  }
  return out;
}

ToiResult toi_of(bool is_face, const Motion& m, ToiMode mode) {
  return is_face ? vertex_face_toi(m.t0, m.t1, mode) : edge_edge_toi(m.t0, m.t1, mode);
}

TEST(Toi, NoPassageThroughAFaceEdgeOrVertexIsMissedAtAnyScale) {
  Grid g{std::mt19937_64(21)};
  int count = 0;
  for (int exponent = -32; exponent <= 10;
       ++exponent)  // coordinates up to 2^10 cells: 1e-7 .. 1e6, and with the offset
    for (const bool is_face : {true, false})
      for (int zeros = 0; zeros < 3; ++zeros)
        for (int i = 0; i < 400; ++i) {
          const int k = g.integer(0, 8);
          const Motion at_origin = touching(g, is_face, zeros, k);
          const Vec3 offset = i % 2 == 0 ? Vec3(Vec3::Zero()) : g.vector(1 << g.integer(0, 24));
          const Motion m = placed(at_origin, std::ldexp(1, exponent), offset);
          for (const ToiMode mode : kModes) {
            const ToiResult r = toi_of(is_face, m, mode);
            ++count;
            ASSERT_TRUE(r.is_contact()) << exponent << " " << is_face << " " << zeros << " " << i;
            ASSERT_LE(r.toi, k / 8.0) << exponent << " " << is_face << " " << zeros << " " << i;
          }
        }
  std::printf("%d touches, none missed, none late\n", count);
}

TEST(Toi, ResultsDoNotDependOnTheOrderOfTheVertices) {
  Grid g{std::mt19937_64(22)};
  Sample s{std::mt19937_64(23)};
  const int faces[6][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 3, 2, 1}};
  const int edges[8][4] = {{0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 3, 2}, {1, 0, 3, 2},
                           {2, 3, 0, 1}, {3, 2, 0, 1}, {2, 3, 1, 0}, {3, 2, 1, 0}};
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v); };
  int contacts = 0;
  for (int i = 0; i < 6000; ++i)
    for (const bool is_face : {true, false})
      for (const ToiMode mode : kModes) {
        Motion m = touching(g, is_face, i % 3, g.integer(0, 8));
        if (i % 2 == 0)
          for (auto* ends : {&m.t0, &m.t1})
            for (Vec3& p : *ends) p = s.cube();
        const ToiResult first = toi_of(is_face, m, mode);
        contacts += first.is_contact();
        for (int n = 0; n < (is_face ? 6 : 8); ++n) {
          const int(&order)[4] = is_face ? faces[n] : edges[n];
          Motion turned;
          for (int p = 0; p < 4; ++p) turned.t0[p] = m.t0[order[p]], turned.t1[p] = m.t1[order[p]];
          const ToiResult r = toi_of(is_face, turned, mode);
          ASSERT_EQ(r.status, first.status);
          ASSERT_EQ(r.is_certain, first.is_certain);
          ASSERT_EQ(bits(r.toi), bits(first.toi));
          ASSERT_EQ(bits(r.toi_upper), bits(first.toi_upper));
          const bool is_swapped = !is_face && order[0] > 1;
          ASSERT_EQ(r.normal, is_swapped ? Vec3(-first.normal) : first.normal);
        }
      }
  EXPECT_GT(contacts, 1000);
}

TEST(Toi, APowerOfTwoScalesNothingButTheCoordinates) {
  Sample s{std::mt19937_64(24)};
  for (int i = 0; i < 20000; ++i) {
    Motion m;
    for (auto* ends : {&m.t0, &m.t1})
      for (Vec3& p : *ends) p = s.cube();
    for (const ToiMode mode : kModes) {
      const ToiResult here = toi_of(i % 2 == 0, m, mode);
      for (const double scale : {0x1p-60, 0x1p-20, 0x1p20, 0x1p60}) {
        const ToiResult there = toi_of(i % 2 == 0, placed(m, scale, Vec3::Zero()), mode);
        ASSERT_EQ(here.status, there.status);
        ASSERT_EQ(here.toi, there.toi);
        ASSERT_EQ(here.toi_upper, there.toi_upper);
      }
    }
  }
}

TEST(Toi, ExactModeIsNeverEarlierAndNeverFindsMore) {
  Grid g{std::mt19937_64(25)};
  Sample s{std::mt19937_64(26)};
  for (int i = 0; i < 20000; ++i) {
    Motion m = touching(g, i % 2 == 0, i % 3, g.integer(0, 8));
    for (Vec3& p : m.t1) p += (i % 4) * 1e-14 * s.cube();
    const ToiResult conservative = toi_of(i % 2 == 0, m, ToiMode::conservative);
    const ToiResult exact = toi_of(i % 2 == 0, m, ToiMode::exact);
    if (exact.is_contact()) {
      ASSERT_TRUE(conservative.is_contact());
      ASSERT_GE(exact.toi, conservative.toi);
    } else {
      ASSERT_FALSE(conservative.is_contact() && conservative.is_certain);
    }
  }
}

TEST(Toi, NothingIsAllocated) {
  Grid g{std::mt19937_64(27)};
  std::vector<Motion> motions;
  for (int i = 0; i < 300; ++i) motions.push_back(touching(g, i % 2 == 0, i % 3, g.integer(0, 8)));
  double sum = 0;
  EXPECT_EQ(allocations_during([&] {
              for (std::size_t i = 0; i < motions.size(); ++i)
                for (const ToiMode mode : kModes) sum += toi_of(i % 2 == 0, motions[i], mode).toi;
            }),
            0);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace kt
