// What a time of impact must be whatever the speed, place, size and shape: nothing tunnels, nothing sticks.
#include "collision/impact/tool_impact.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "collision/held/first_contact.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/collision_oracle.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr double kStep = 1e-3;  // [s]
const ToolShape kPoint;

ToolShape sphere(double radius) { return {ToolShape::Kind::sphere, radius}; }

/// A surface at rest, and the first contact with it by the backend without approximations.
struct Surface {
  std::vector<Triangle> triangles;
  VectorX x;
  std::unique_ptr<TriangleIndex> index = make_triangle_index("brute_force");
  Surface(std::vector<Triangle> t, VectorX positions) : triangles(std::move(t)), x(std::move(positions)) {
    index->build(triangles, x);
  }
  std::optional<Contact> hit(const ToolShape& tool, const ToolSweep& sweep) const {
    std::vector<int> scratch(triangles.size());
    return find_first_contact(*index, {triangles, x, x}, tool, sweep, {}, scratch);
  }
};

Surface sphere_mesh(double scale = 1, const Vec3& centre = Vec3::Zero()) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  VectorX x = scale * mesh.x;
  for (int i = 0; i < mesh.num_nodes(); ++i) node(x, i) += centre;
  return {mesh.triangles, x};
}

/// A point of a triangle: inside, on an edge or at a vertex.
Vec3 target_on(Sample& s, const Surface& surface, int zeros) {
  const Triangle& t = surface.triangles[s.random() % surface.triangles.size()];
  Vec3 bary(s.uniform(0.01, 1), zeros < 2 ? s.uniform(0.01, 1) : 0, zeros < 1 ? s.uniform(0.01, 1) : 0);
  bary /= bary.sum();
  return bary[0] * node(surface.x, t[0]) + bary[1] * node(surface.x, t[1]) + bary[2] * node(surface.x, t[2]);
}

TEST(Tunnelling, NoShotAtAFaceEdgeOrVertexPassesAtAnySpeed) {
  Sample s{std::mt19937_64(11)};
  for (const double scale : {1e-6, 1.0, 1e3})
    for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(1e3, -1e3, 1e3)}) {
      if (scale < 1 && centre.x() > 0) continue;  // such a sphere is lost in the rounding of its place
      const Surface surface = sphere_mesh(scale, centre);
      // What rounding of places so far out is worth, and the faces' distance from the round sphere.
      const double roundoff = 1e-13 * (centre.norm() + scale);
      for (double speed = 0.1; speed <= 1e4; speed *= 10)
        for (int zeros = 0; zeros < 3; ++zeros)
          for (int i = 0; i < 40; ++i) {
            const Vec3 target = target_on(s, surface, zeros);
            Vec3 way = scale * speed * kStep * s.cube().normalized();
            if (way.dot(target - centre) > 0) way = -way;  // towards the middle
            // Rounding of places far out makes a shot along the surface one that passes by.
            const double slope = -way.normalized().dot((target - centre).normalized());
            if (centre.x() > 0 && slope < 0.3) continue;
            const double before = s.uniform(0, 1);
            const ToolSweep sweep{target - before * way, target + (1 - before) * way};
            if ((sweep.x_t0 - centre).norm() < 0.0301 * scale) continue;  // starts in or at the sphere
            const double radius = s.uniform(0, 1) < 0.5 ? 0 : 0.002 * scale;
            if (radius > 0 && (sweep.x_t0 - centre).norm() < 0.0321 * scale) continue;
            const auto hit = surface.hit(radius > 0 ? sphere(radius) : kPoint, sweep);
            ASSERT_TRUE(hit) << scale << " " << speed << " " << zeros << " " << i;
            EXPECT_LE(hit->toi, before + roundoff / way.norm());
            EXPECT_LE(hit->gap, roundoff + way.norm() * 1e-12);
          }
    }
}

TEST(Tunnelling, AThinSheetStopsToolsFromBothSides) {
  // Two layers 5 nm apart, outward normals up and down.
  const VectorX x{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1e-6, 1, 0, -1e-6, 0, 1, -1e-6}};
  const Surface sheet({{0, 1, 2}, {3, 5, 4}}, 5e-3 * x);
  for (double speed = 0.1; speed <= 1e4; speed *= 10)
    for (const double z : {1.0, -1.0}) {
      const Vec3 target(1e-3, 1e-3, 0), way(0, 0, -z * speed * kStep);
      const auto hit = sheet.hit(kPoint, {target - 0.5 * way, target + 0.5 * way});
      ASSERT_TRUE(hit);
      EXPECT_EQ(hit->triangle, z > 0 ? 0 : 1);
      EXPECT_NEAR(hit->toi, 0.5, 1.01 * 5e-9 / way.norm());
      EXPECT_NEAR(hit->normal.z(), z, 1e-12);
      EXPECT_TRUE(sheet.hit(sphere(1e-5), {target - 0.5 * way, target + 0.5 * way}));
    }
}

const Vec3 kTriangle[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

TEST(PointTriangleToi, MotionInThePlaneHitsTheEdge) {
  const auto hit = find_triangle_impact(kPoint, {{-1, 0.25, 0}, {1, 0.25, 0}}, kTriangle, kTriangle);
  ASSERT_TRUE(hit);
  EXPECT_LE(hit->toi, 0.5);
  EXPECT_NEAR(hit->toi, 0.5, 1e-12);
  EXPECT_FALSE(find_triangle_impact(kPoint, {{-1, -0.25, 0}, {1, -0.25, 0}}, kTriangle, kTriangle));
}

TEST(PointTriangleToi, AGrazedVertexIsHit) {
  const auto hit = find_triangle_impact(kPoint, {{0.5, 1, 1}, {-0.5, 1, -1}}, kTriangle, kTriangle);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->toi, 0.5, 1e-12);
  EXPECT_NEAR(hit->bary[2], 1, 1e-12);
}

TEST(PointTriangleToi, IsOneSided) {
  EXPECT_TRUE(find_triangle_impact(kPoint, {{0.2, 0.2, 1}, {0.2, 0.2, -1}}, kTriangle, kTriangle));
  EXPECT_FALSE(find_triangle_impact(kPoint, {{0.2, 0.2, -1}, {0.2, 0.2, 1}}, kTriangle, kTriangle));
  EXPECT_TRUE(find_triangle_impact(sphere(0.1), {{0.2, 0.2, 1}, {0.2, 0.2, -1}}, kTriangle, kTriangle));
  EXPECT_FALSE(find_triangle_impact(sphere(0.1), {{0.2, 0.2, -1}, {0.2, 0.2, 1}}, kTriangle, kTriangle));
}

TEST(PointTriangleToi, TouchingIsAHitOnlyWhenApproaching) {
  const Vec3 touch(0.2, 0.3, 0);
  for (const double radius : {0.0, 0.25}) {
    const ToolShape tool{radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, radius};
    const Vec3 start = touch + radius * Vec3::UnitZ();
    const auto to = [&](const Vec3& way) {
      return find_triangle_impact(tool, {start, start + way}, kTriangle, kTriangle);
    };
    EXPECT_FALSE(to({0, 0, 0}));
    EXPECT_FALSE(to({0, 0, 1}));
    EXPECT_FALSE(to({0.1, 0.2, 1e-9}));
    EXPECT_FALSE(to({0.1, 0.2, 0}));
    const auto hit = to({0.1, 0.2, -1e-9});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->toi, 0);
    EXPECT_EQ(hit->normal, Vec3(0, 0, 1));
  }
}

TEST(PointTriangleToi, ATouchingToolDoesNotSinkIntoATurningTriangle) {
  // The surface rises as (x - 1e-9) t: at first it sinks away, by 1e-18 at most, then the tool is in it.
  constexpr double kSink = 1e-9;
  const Vec3 t0[3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  const Vec3 t1[3] = {{-1, -1, -1 - kSink}, {1, -1, 1 - kSink}, {0, 1, -kSink}};
  const auto hit = find_triangle_impact(kPoint, {{0, 0, 0}, {0.3, 0, 0}}, t0, t1);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->toi, 0);
}

TEST(PointTriangleToi, AToolThatLeavesAndReturnsWithinTheStepIsHit) {
  // The surface at the tool is 0.1 (t - 1/4) (t - 3/4) high: the tool comes out at 1/4 and is hit at 3/4.
  const auto corner = [](double material_x, double y, double t) {
    return Vec3(material_x + t, y, 0.1 * (0.1875 - t - t * material_x));
  };
  const Vec3 t0[3] = {corner(-9, -9, 0), corner(9, -9, 0), corner(0, 9, 0)};
  const Vec3 t1[3] = {corner(-9, -9, 1), corner(9, -9, 1), corner(0, 9, 1)};
  // Of the sphere, which overlaps all the time, the centre does so.
  for (const ToolShape& tool : {kPoint, sphere(0.3)}) {
    const auto hit = find_triangle_impact(tool, {Vec3::Zero(), Vec3::Zero()}, t0, t1);
    ASSERT_TRUE(hit);
    EXPECT_LE(hit->toi, 0.75);
    EXPECT_NEAR(hit->toi, 0.75, 1e-11);
  }
}

TEST(SphereTriangleToi, AnOverlappingSphereThatFirstRecedesDoesNotSinkIn) {
  // The surface rises as (x - 0.1) t under a sphere that overlaps all the time: at its start away from it, then over
  // its centre.
  const Vec3 t0[3] = {{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}};
  const Vec3 t1[3] = {{-9, -9, -9.1}, {9, -9, 8.9}, {0, 9, -0.1}};
  const auto hit = find_triangle_impact(sphere(1), {{0, 0, 0.01}, {0.3, 0, 0.01}}, t0, t1);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->toi, 0);
}

TEST(PointTriangleToi, DegenerateTrianglesAreHit) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), half(0.5, 0, 0);
  for (const auto& v : {std::array{a, b, half}, {a, half, b}, {a, a, b}, {half, half, half}}) {
    const Vec3 triangle[3] = {v[0], v[1], v[2]};
    const auto hit = find_triangle_impact(kPoint, {{0.5, 0.3, 0.4}, {0.5, -0.3, -0.4}}, triangle, triangle);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->toi, 0.5, 1e-12);
    EXPECT_NEAR(hit->normal.dot(Vec3(0, 0.6, 0.8)), 1, 1e-12);  // faces the motion
    EXPECT_TRUE(find_triangle_impact(sphere(0.1), {{0.5, 0.3, 0.4}, {0.5, -0.3, -0.4}}, triangle, triangle));
    EXPECT_FALSE(find_triangle_impact(kPoint, {half, {0.5, -0.3, -0.4}}, triangle, triangle));
  }
}

TEST(SphereTriangleToi, TrianglesThatRoundingLeavesSomeAreaAreHitWhereTheyAre) {
  // Three points on a line, or two in one place, that turn: their normals and shortest edges point anywhere. Contact
  // was seen from as far as the triangle is long.
  Sample s{std::mt19937_64(13)};
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    CollisionQuery q;
    q.tool_t0 = s.cube();
    q.tool_t1 = s.cube();
    const Vec3 a = s.cube(), b = s.cube();
    const double share = i % 2 ? s.uniform(0, 1) : 0;
    const Mat3 turn = Eigen::AngleAxisd(0.1, s.cube().normalized()).toRotationMatrix();
    const Vec3 v[3] = {a, b, a + share * (b - a)};
    for (int k = 0; k < 3; ++k) {
      q.triangle_t0[k] = turn * v[k];
      q.triangle_t1[k] = turn * q.triangle_t0[k];
    }
    const double radius = 0.1;
    const auto hit = find_triangle_impact(sphere(radius), {q.tool_t0, q.tool_t1}, q.triangle_t0, q.triangle_t1);
    if (!hit || exact_distance(q, 0) < radius) continue;
    ++hits;
    EXPECT_NEAR(exact_distance(q, hit->toi), radius, 1e-12);
    const Vec3 foot =
        hit->bary[0] * q.triangle_t0[0] + hit->bary[1] * q.triangle_t0[1] + hit->bary[2] * q.triangle_t0[2];
    const Vec3 foot_t1 =
        hit->bary[0] * q.triangle_t1[0] + hit->bary[1] * q.triangle_t1[1] + hit->bary[2] * q.triangle_t1[2];
    const Vec3 out = q.tool_t0 + hit->toi * (q.tool_t1 - q.tool_t0) - (foot + hit->toi * (foot_t1 - foot));
    EXPECT_NEAR(out.normalized().dot(hit->normal), 1, 1e-12);
  }
  EXPECT_GT(hits, 1000);
}

TEST(PointTriangleToi, NoNumberGivesNoHit) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e308})
    for (int i = 0; i < 24; ++i) {
      double p[24] = {0.2, 0.2, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2, 0.2, -1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
      p[i] = bad;
      const auto v = [&](int k) { return Vec3(p[3 * k], p[3 * k + 1], p[3 * k + 2]); };
      const Vec3 t0[3] = {v(1), v(2), v(3)}, t1[3] = {v(5), v(6), v(7)};
      for (const ToolShape& tool : {kPoint, sphere(0.1)}) {
        const auto hit = find_triangle_impact(tool, {v(0), v(4)}, t0, t1);
        if (!std::isfinite(bad)) {
          EXPECT_FALSE(hit) << bad << " " << i;
        }
      }
    }
}

TEST(PointTriangleToi, PassingAVertexSquareToItsEdgeIsNoHit) {
  // Here rounding turned the plane across the vertex into the edge: contact was seen 8e-13 away, three times the bound.
  const Vec3 t0[3] = {{0.084399248885991263, 0.018533872132342477, 0.10919319025453933},
                      {-0.068357051426046977, 0.13612563985493376, 0.021730739346812467},
                      {0.045303620502548325, 0.13191478894316933, 0.12759031218264072}};
  const Vec3 t1[3] = {{0.084035449242706006, 0.01818344692831575, 0.10935781653474907},
                      {-0.068720851069332234, 0.13577521465090703, 0.021895365627022212},
                      {0.044939820859263069, 0.1315643637391426, 0.12775493846285046}};
  EXPECT_FALSE(find_triangle_impact(kPoint,
                                    {{-0.0017163436649322641, 0.053175107177827863, 0.17557723647603798},
                                     {0.51567005730565696, 0.91984971595868847, -0.35265581086283126}},
                                    t0, t1));
}

TEST(SphereTriangleToi, TheEdgeOfASliverIsHitFromBehindWhereRoundingTurnsItsNormal) {
  // A sphere of 7.9 whose foot is 2e-7 beside a face of the height 6e-7: it was taken to be on the face.
  const Vec3 triangle[3] = {{-34.009192077957778, -27.467420843802529, 221.05514450629289},
                            {144.70907304046432, 199.81678385904092, -189.54936755316476},
                            {105.79821055582397, 150.33205669608287, -100.15181346281224}};
  EXPECT_TRUE(find_triangle_impact(sphere(7.917428498112387),
                                   {{102.31445385955232, 139.09792916683352, -72.892429657828998},
                                    {102.31178846077361, 139.10191116512667, -72.899557701841744}},
                                   triangle, triangle));
}

TEST(PointTriangleToi, ScaleAndOrderOfTheVerticesDoNotMatter) {
  Sample s{std::mt19937_64(12)};
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    Vec3 t0[3], t1[3];
    for (int k = 0; k < 3; ++k) {
      t0[k] = s.cube();
      t1[k] = t0[k] + s.cube();
    }
    const ToolSweep sweep{0.5 * s.cube(), s.cube()};
    const ToolShape tool = i % 2 ? sphere(0.1) : kPoint;
    const auto hit = find_triangle_impact(tool, sweep, t0, t1);
    hits += hit.has_value();
    EXPECT_EQ(find_triangle_impact(tool, sweep, t0, t1), hit);
    for (const double scale : {0x1p-20, 0x1p10}) {
      Vec3 u0[3], u1[3];
      for (int k = 0; k < 3; ++k) {
        u0[k] = scale * t0[k];
        u1[k] = scale * t1[k];
      }
      auto scaled =
          find_triangle_impact({tool.kind, scale * tool.radius}, {scale * sweep.x_t0, scale * sweep.x_t1}, u0, u1);
      if (scaled) scaled->gap /= scale;
      EXPECT_EQ(scaled, hit);  // a power of two rounds nothing
    }
    const Vec3 turned_t0[3] = {t0[1], t0[2], t0[0]}, turned_t1[3] = {t1[1], t1[2], t1[0]};
    const auto turned = find_triangle_impact(tool, sweep, turned_t0, turned_t1);
    ASSERT_EQ(turned.has_value(), hit.has_value());
    if (hit) {
      EXPECT_NEAR(turned->toi, hit->toi, 1e-9);
    }
  }
  EXPECT_GT(hits, 100);
}

}  // namespace
}  // namespace kt
