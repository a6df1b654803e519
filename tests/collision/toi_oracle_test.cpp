// Times of impact against all roots in 113-bit arithmetic, over motions on small integer grids: these touch exactly at
// vertices and edges, graze, stay in a plane or a line and degenerate far more often than random numbers do. Moved and
// scaled without rounding, the answer stays the same.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "collision/impact/feature_toi.hpp"
#include "tests/support/toi_oracle.hpp"

namespace kt {
namespace {

// Of the step: a root of multiplicity three is uncertain by the cube root of rounding, a double one by the square root.
constexpr double kEarlyExact = 1e-10;

struct Random {
  std::mt19937_64 engine;
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine); }
};

/// kinds: 0 anything; 1 in a plane z = 0; 2 on a line; 3 the second feature is degenerate at times; 4 nothing turns.
IntegerMotion random_motion(Random& r, int range, int kind) {
  IntegerMotion x;
  for (auto* ends : {&x.t0, &x.t1})
    for (auto& p : *ends)
      for (int k = 0; k < 3; ++k) p[k] = k > 0 && kind == 2 ? 0 : k == 2 && kind == 1 ? 0 : r.integer(-range, range);
  if (kind == 3)
    for (int k = 0; k < 3; ++k) {
      x.t0[3][k] = x.t0[2][k];
      if (r.integer(0, 1) == 0) x.t1[3][k] = x.t1[2][k];
    }
  if (kind == 4)
    for (int i = 1; i < 4; ++i)
      for (int k = 0; k < 3; ++k) x.t1[i][k] = x.t0[i][k] + x.t1[3][k] - x.t0[3][k];
  return x;
}

struct Placed {
  Vec3 t0[4], t1[4];
};

/// The grid with cells of 2^exponent, moved by a whole number of cells.
Placed place(const IntegerMotion& x, int exponent, const Vec3& offset) {
  Placed out;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      out.t0[i][k] = std::ldexp(x.t0[i][k] + offset[k], exponent);
      out.t1[i][k] = std::ldexp(x.t1[i][k] + offset[k], exponent);
    }
  return out;
}

ToiResult toi_of(bool is_face, const Placed& x, ToiMode mode) {
  return is_face ? vertex_face_toi(x.t0, x.t1, mode) : edge_edge_toi(x.t0, x.t1, mode);
}

struct Count {
  int queries = 0, contacts = 0, false_hits = 0, open = 0;
  double earliest = 0;
};

void compare(const ToiResult& r, const std::optional<double>& truth, Count& c) {
  ++c.queries;
  c.contacts += truth.has_value();
  ASSERT_NE(r.status, ToiResult::Status::invalid_input);
  if (!truth) {
    c.false_hits += r.is_contact();
    EXPECT_FALSE(r.is_contact() && r.is_certain);
    return;
  }
  ASSERT_TRUE(r.is_contact());
  c.open += !r.is_certain;
  // The truth is rounded to nearest.
  EXPECT_LE(r.toi, std::nextafter(*truth, 2));
  EXPECT_GE(r.toi_upper, std::nextafter(*truth, -1));
  EXPECT_GE(r.toi, 0);
  EXPECT_LE(r.toi_upper, 1);
  EXPECT_NEAR(r.normal.norm(), 1, 1e-14);
  c.earliest = std::max(c.earliest, *truth - r.toi);
}

void run(const char* name, bool is_face, int range, int queries, unsigned seed) {
  Random r{std::mt19937_64(seed)};
  Count conservative, exact;
  for (int i = 0; i < queries; ++i) {
    const IntegerMotion x = random_motion(r, range, i % 5);
    const auto truth = is_face ? first_contact_of_vertex_face(x) : first_contact_of_edges(x);
    const int exponent = r.integer(-22, 22);
    const int far = i % 3 == 0 ? 0 : 1 << r.integer(0, 20);
    const Vec3 offset(r.integer(-far, far), r.integer(-far, far), r.integer(-far, far));
    const Placed placed = place(x, exponent, offset);
    compare(toi_of(is_face, placed, ToiMode::conservative), truth, conservative);
    compare(toi_of(is_face, placed, ToiMode::exact), truth, exact);
    if (testing::Test::HasFailure()) {
      for (const auto* ends : {&x.t0, &x.t1})
        for (const auto& p : *ends) std::printf("%d %d %d\n", p[0], p[1], p[2]);
      FAIL() << name << " " << i << ", truth " << truth.value_or(-1) << ", 2^" << exponent << ", "
             << offset.transpose();
    }
  }
  for (const auto& [mode, c] : {std::pair("conservative", conservative), std::pair("exact", exact)})
    std::printf("%s, %s: %d queries, %d contacts, %d hits where nothing meets, %d open, earliest %.2g of the step\n",
                name, mode, c.queries, c.contacts, c.false_hits, c.open, c.earliest);
  EXPECT_EQ(exact.false_hits, 0);
  EXPECT_LT(exact.earliest, kEarlyExact);
  EXPECT_GT(exact.contacts, queries / 20);
  EXPECT_GT(queries - exact.contacts, queries / 20);
}

TEST(VertexFaceToi, IsTheFirstContactOnSmallGrids) { run("vertex-face, grid of 2", true, 2, 20000, 1); }
TEST(VertexFaceToi, IsTheFirstContactOnGrids) { run("vertex-face, grid of 7", true, 7, 20000, 2); }
TEST(EdgeEdgeToi, IsTheFirstContactOnSmallGrids) { run("edge-edge, grid of 2", false, 2, 20000, 3); }
TEST(EdgeEdgeToi, IsTheFirstContactOnGrids) { run("edge-edge, grid of 7", false, 7, 20000, 4); }

}  // namespace
}  // namespace kt
