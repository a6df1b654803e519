// Times of impact that are known by hand.
#include "collision/impact/feature_toi.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>

namespace kt {

void PrintTo(ToiResult::Status s, std::ostream* out) { *out << int{static_cast<unsigned char>(s)}; }

namespace {

using Kind = ToiFeature::Kind;
using Status = ToiResult::Status;

constexpr double kSharp = 1e-14;  // of the step: rounding, for coordinates of about 1 at a speed of about 1
constexpr ToiMode kModes[] = {ToiMode::conservative, ToiMode::exact};

/// A vertex that moves from p to q, and a face at rest.
ToiResult shoot(const Vec3& p, const Vec3& q, ToiMode mode = ToiMode::exact, double scale = 1) {
  const Vec3 t0[4] = {scale * p, scale * Vec3(0, 0, 0), scale * Vec3(1, 0, 0), scale * Vec3(0, 1, 0)};
  const Vec3 t1[4] = {scale * q, t0[1], t0[2], t0[3]};
  return vertex_face_toi(t0, t1, mode);
}

/// An edge from a0 to a1 that moves by `way`, and the edge from (-1, 0, 0) to (1, 0, 0) at rest.
ToiResult sweep(const Vec3& a0, const Vec3& a1, const Vec3& way, ToiMode mode = ToiMode::exact) {
  const Vec3 t0[4] = {a0, a1, {-1, 0, 0}, {1, 0, 0}};
  const Vec3 t1[4] = {a0 + way, a1 + way, t0[2], t0[3]};
  return edge_edge_toi(t0, t1, mode);
}

void expect_time(const ToiResult& r, double toi) {
  EXPECT_EQ(r.status, Status::hit);
  EXPECT_LE(r.toi, toi);
  EXPECT_GE(r.toi_upper, toi);
  EXPECT_NEAR(r.toi, toi, kSharp);
}

TEST(VertexFaceToi, AFaceIsHitFromBothSides) {
  for (const ToiMode mode : kModes)
    for (const double side : {1.0, -1.0}) {
      const ToiResult r = shoot({0.25, 0.5, side}, {0.25, 0.5, -3 * side}, mode);
      expect_time(r, 0.25);
      EXPECT_TRUE(r.is_certain);
      EXPECT_NEAR(r.toi_upper, 0.25, kSharp);
      EXPECT_EQ(r.first, (ToiFeature{Kind::vertex, 0}));
      EXPECT_EQ(r.second.kind, Kind::face);
      EXPECT_NEAR((r.normal - side * Vec3::UnitZ()).norm(), 0, kSharp);
      EXPECT_EQ(r.weight[0], 1);
      EXPECT_NEAR(r.weight[1], 0.25, kSharp);
      EXPECT_NEAR(r.weight[2], 0.25, kSharp);
      EXPECT_NEAR(r.weight[3], 0.5, kSharp);
    }
}

TEST(VertexFaceToi, WhoPassesBesideIsNoHit) {
  for (const ToiMode mode : kModes) {
    EXPECT_EQ(shoot({0.6, 0.6, 1}, {0.6, 0.6, -1}, mode).status, Status::none);
    EXPECT_EQ(shoot({0.25, 0.25, 2}, {0.25, 0.25, 1}, mode).status, Status::none);
    EXPECT_EQ(shoot({-1e-12, 0.5, 1}, {-1e-12, 0.5, -1}, mode).status, Status::none);
  }
}

TEST(VertexFaceToi, EdgesAndVerticesOfTheFaceBelongToIt) {
  for (const ToiMode mode : kModes)
    for (const double scale : {0x1p-20, 0x1p-10, 1.0, 0x1p10, 0x1p20}) {
      const ToiResult edge = shoot({0.5, 0.5, 1}, {0.5, 0.5, -1}, mode, scale);
      expect_time(edge, 0.5);
      EXPECT_EQ(edge.second, (ToiFeature{Kind::edge, 1}));
      for (int i = 0; i < 3; ++i) {
        const Vec3 corner(i == 1, i == 2, 0);
        const ToiResult vertex = shoot(corner + Vec3(0, 0, 1), corner - Vec3(0, 0, 1), mode, scale);
        expect_time(vertex, 0.5);
        EXPECT_EQ(vertex.second, (ToiFeature{Kind::vertex, static_cast<unsigned char>(i + 1)}));
        EXPECT_NEAR(vertex.weight[i + 1], 1, kSharp);
      }
    }
}

TEST(VertexFaceToi, ExactModeTellsATouchFromAMissOfOneUlp) {
  // Through the edge x = 0, and half an ulp of 0.7 beside it.
  const Vec3 start(0.7, 0.3, 1), through(-0.7, 0.3, -1), beside(std::nextafter(-0.7, -1), 0.3, -1);
  EXPECT_TRUE(shoot(start, through).is_contact());
  EXPECT_FALSE(shoot(start, beside).is_contact());
  EXPECT_TRUE(shoot(start, beside, ToiMode::conservative).is_contact());
  EXPECT_FALSE(shoot(start, beside, ToiMode::conservative).is_certain);
  // It reaches the face at the very end, or not quite.
  EXPECT_TRUE(shoot({0.25, 0.25, 1}, {0.25, 0.25, 0}).is_contact());
  EXPECT_FALSE(shoot({0.25, 0.25, 1}, {0.25, 0.25, 0x1p-60}).is_contact());
}

TEST(VertexFaceToi, ContactAtTheStartIsAlreadyInsideWhateverFollows) {
  for (const ToiMode mode : kModes)
    for (const Vec3& end : {Vec3(0.2, 0.2, 1), Vec3(0.2, 0.2, -1), Vec3(0.3, 0.2, 0), Vec3(0.2, 0.2, 0)}) {
      const ToiResult r = shoot({0.2, 0.2, 0}, end, mode);
      EXPECT_EQ(r.status, Status::already_inside);
      EXPECT_EQ(r.toi, 0);
      EXPECT_EQ(r.is_certain, mode == ToiMode::exact);
    }
}

TEST(VertexFaceToi, MotionInThePlaneHitsTheEdge) {
  for (const ToiMode mode : kModes) {
    const ToiResult r = shoot({-1, 0.25, 0}, {1, 0.25, 0}, mode);
    expect_time(r, 0.5);
    EXPECT_EQ(r.second, (ToiFeature{Kind::edge, 2}));
    EXPECT_FALSE(shoot({-1, -0.25, 0}, {1, -0.25, 0}, mode).is_contact());
    expect_time(shoot({0.5, -1, 0}, {0.5, 3, 0}, mode), 0.25);
    expect_time(shoot({-2, 0, 0}, {2, 0, 0}, mode), 0.5);  // along an edge
  }
}

TEST(VertexFaceToi, ATriangleWithoutAreaIsItsEdges) {
  const Vec3 a(0, 0, 0), b(4, 2, 0), middle(2, 1, 0), v0(2, 1, 3), v1(2, 1, -1);
  for (const ToiMode mode : kModes)
    for (const auto& f : {std::array{a, b, middle}, {a, middle, b}, {b, a, a}, {middle, middle, middle}}) {
      const Vec3 t0[4] = {v0, f[0], f[1], f[2]}, t1[4] = {v1, f[0], f[1], f[2]};
      expect_time(vertex_face_toi(t0, t1, mode), 0.75);
      const Vec3 beside_t0[4] = {v0 + Vec3(4, 2, 0), f[0], f[1], f[2]};
      const Vec3 beside_t1[4] = {v1 + Vec3(4, 2, 0), f[0], f[1], f[2]};
      EXPECT_FALSE(vertex_face_toi(beside_t0, beside_t1, mode).is_contact());
    }
}

TEST(VertexFaceToi, AFaceThatTurnsOverMeetsTheVertexWhereItIsALine) {
  // At t = 1/2 the face is the segment from (0, 0, 0) to (1, 0, 0).
  for (const ToiMode mode : kModes)
    for (const double x : {0.5, 1.5}) {
      const Vec3 t0[4] = {{x, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0.25, 0.25, 1}};
      const Vec3 t1[4] = {{x, -1, 0}, {0, 0, 0}, {1, 0, 0}, {0.25, -0.25, -1}};
      const ToiResult r = vertex_face_toi(t0, t1, mode);
      EXPECT_EQ(r.is_contact(), x == 0.5);
      if (x != 0.5) continue;
      EXPECT_LE(r.toi, 0.5);
      // A double root of the distance: rounding leaves the square root of rounding open.
      EXPECT_NEAR(r.toi, 0.5, mode == ToiMode::exact ? kSharp : 1e-7);
    }
}

TEST(EdgeEdgeToi, CrossingEdgesTouch) {
  for (const ToiMode mode : kModes) {
    const ToiResult r = sweep({0.5, -1, 1}, {0.5, 3, 1}, {0, 0, -4}, mode);
    expect_time(r, 0.25);
    EXPECT_TRUE(r.is_certain);
    EXPECT_EQ(r.first, (ToiFeature{Kind::edge, 0}));
    EXPECT_EQ(r.second, (ToiFeature{Kind::edge, 0}));
    EXPECT_NEAR((r.normal - Vec3::UnitZ()).norm(), 0, kSharp);
    for (const auto& [i, w] : {std::pair(0, 0.75), {1, 0.25}, {2, 0.25}, {3, 0.75}})
      EXPECT_NEAR(r.weight[i], w, kSharp);
    EXPECT_FALSE(sweep({1.5, -1, 1}, {1.5, 3, 1}, {0, 0, -4}, mode).is_contact());
  }
}

TEST(EdgeEdgeToi, EndsBelongToTheEdges) {
  for (const ToiMode mode : kModes) {
    const ToiResult tee = sweep({0.5, 0, 1}, {0.5, 3, 1}, {0, 0, -2}, mode);
    expect_time(tee, 0.5);
    EXPECT_EQ(tee.first, (ToiFeature{Kind::vertex, 0}));
    const ToiResult corner = sweep({1, -2, 1}, {1, 0, 1}, {0, 0, -2}, mode);
    expect_time(corner, 0.5);
    EXPECT_EQ(corner.first, (ToiFeature{Kind::vertex, 1}));
    EXPECT_EQ(corner.second, (ToiFeature{Kind::vertex, 3}));
  }
}

TEST(EdgeEdgeToi, ParallelAndCollinearEdgesTouch) {
  for (const ToiMode mode : kModes) {
    expect_time(sweep({0, 0, 1}, {3, 0, 1}, {0, 0, -2}, mode), 0.5);   // parallel
    expect_time(sweep({2, 0, 0}, {3, 0, 0}, {-4, 0, 0}, mode), 0.25);  // in one line
    EXPECT_FALSE(sweep({2, 0, 1}, {3, 0, 1}, {0, 0, -2}, mode).is_contact());
    EXPECT_FALSE(sweep({3, 0, 0}, {4, 0, 0}, {-1, 0, 0}, mode).is_contact());
  }
}

TEST(EdgeEdgeToi, EdgesWithoutLengthAreVertices) {
  for (const ToiMode mode : kModes) {
    expect_time(sweep({0.5, 0, 1}, {0.5, 0, 1}, {0, 0, -2}, mode), 0.5);
    EXPECT_FALSE(sweep({1.5, 0, 1}, {1.5, 0, 1}, {0, 0, -2}, mode).is_contact());
    const Vec3 p(1, 2, 3), q(0, 1, 0), way(1, -1, 1);
    const Vec3 t0[4] = {p - way, p - way, q, q}, t1[4] = {p + 3 * way, p + 3 * way, 4 * p - 3 * q, 4 * p - 3 * q};
    expect_time(edge_edge_toi(t0, t1, mode), 0.25);
  }
}

TEST(EdgeEdgeToi, TheNormalIsThatOfTheFirstEdgesSide) {
  const ToiResult up = sweep({0, -1, 1}, {0, 1, 1}, {0, 0, -2}), down = sweep({0, -1, -1}, {0, 1, -1}, {0, 0, 2});
  EXPECT_NEAR(up.normal.z(), 1, kSharp);
  EXPECT_NEAR(down.normal.z(), -1, kSharp);
}

TEST(Toi, NumbersThatAreNoneOrTooLargeAreInvalid) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity, 1e200, -0x1.1p100})
    for (int i = 0; i < 24; ++i) {
      double x[24] = {0.2, 0.2, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2, 0.2, -1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
      x[i] = bad;
      Vec3 t0[4], t1[4];
      for (int k = 0; k < 4; ++k) {
        t0[k] = Vec3(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
        t1[k] = Vec3(x[12 + 3 * k], x[13 + 3 * k], x[14 + 3 * k]);
      }
      for (const ToiMode mode : kModes)
        for (const ToiResult& r : {vertex_face_toi(t0, t1, mode), edge_edge_toi(t0, t1, mode)}) {
          EXPECT_EQ(r.status, Status::invalid_input);
          EXPECT_FALSE(r.is_contact());
        }
    }
}

TEST(Toi, TheValidRangeEndsWhereItSays) {
  for (const ToiMode mode : kModes) {
    EXPECT_TRUE(shoot({0.25, 0.25, 1}, {0.25, 0.25, -1}, mode, kLargestCoordinate).is_contact());
    EXPECT_TRUE(shoot({0.25, 0.25, 1}, {0.25, 0.25, -1}, mode, kSmallestExtent).is_contact());
    EXPECT_EQ(shoot({0.25, 0.25, 1}, {0.25, 0.25, -1}, mode, 0.5 * kSmallestExtent).status, Status::invalid_input);
    EXPECT_FALSE(shoot({0.6, 0.6, 1}, {0.6, 0.6, -1}, mode, kLargestCoordinate).is_contact());
    EXPECT_FALSE(shoot({0.6, 0.6, 1}, {0.6, 0.6, -1}, mode, kSmallestExtent).is_contact());
    const Vec3 zero[4] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    EXPECT_EQ(vertex_face_toi(zero, zero, mode).status, Status::already_inside);
    EXPECT_EQ(edge_edge_toi(zero, zero, mode).status, Status::already_inside);
    // Single coordinates may be as small as they like.
    expect_time(shoot({0.25, 0.25, 1}, {0.25, 0.25 + 1e-310, -1}, mode), 0.5);
    EXPECT_FALSE(shoot({-0.25, 1e-310, 1}, {-0.25, 1e-320, -1}, mode).is_contact());
  }
}

TEST(Toi, TheNormalIsAUnitVectorWhereTheSquareOfAMotionUnderflows) {
  const Vec3 zero = Vec3::Zero();
  const Vec3 t0[4] = {Vec3(-0x1.e9p-534, 0x1p-1060, 0), Vec3(0x1p-76, 0, 0), zero, zero};
  const Vec3 t1[4] = {zero, zero, zero, zero};
  for (const ToiMode mode : kModes) {
    const ToiResult r = vertex_face_toi(t0, t1, mode);
    ASSERT_TRUE(r.is_contact());
    EXPECT_NEAR(r.normal.norm(), 1, kSharp);
  }
}

}  // namespace
}  // namespace kt
