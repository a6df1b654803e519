// How far a surface is pushed in along the contact normal: hand values, and every triangle looked at by another
// formula.
#include "haptics/session/indentation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // [m] of a body of centimetres

/// The same by planes and areas: the line meets the plane of a triangle, and the three triangles with that point have
/// the area of the one.
double every_triangle(const Mesh& mesh, const Vec3& p, const Vec3& d) {
  double nearest = std::numeric_limits<double>::quiet_NaN();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]), b = node(mesh.x, t[1]), c = node(mesh.x, t[2]);
    const Vec3 area = (b - a).cross(c - a);
    if (!(area.dot(d) > 0)) continue;
    const double s = area.dot(a - p) / area.dot(d);
    const Vec3 at = p + s * d;
    const double parts = (b - at).cross(c - at).norm() + (c - at).cross(a - at).norm() + (a - at).cross(b - at).norm();
    if (parts > area.norm() * (1 + 1e-9)) continue;
    if (!(std::abs(s) >= std::abs(nearest))) nearest = s;
  }
  return nearest;
}

TEST(Indentation, IsTheWayToTheFlatSurfaceAlongTheNormal) {
  const Mesh block = kuhn_block(4, 4, 4, 0.005);  // its top at z = 20 mm
  const Indentation indentation(block.triangles, block.x);
  const Vec3 up = Vec3::UnitZ(), place(0.0111, 0.0093, 0.017);
  EXPECT_NEAR(indentation.at(place, up), 0.003, kRoundoff);
  EXPECT_NEAR(indentation.at(place + 0.005 * up, up), -0.002, kRoundoff) << "the surface has come out";
  const double angle = 0.5;
  EXPECT_NEAR(indentation.at(place, Vec3(std::sin(angle), 0, std::cos(angle))), 0.003 / std::cos(angle), kRoundoff);
}

TEST(Indentation, IsNotAnHeightOnASlope) {
  // A tool that keeps 3 mm deep below a slope of 45 degrees, whichever way it has gone down.
  Mesh block = kuhn_block(8, 4, 4, 0.005);
  for (int i = 0; i < block.num_nodes(); ++i) node(block.x, i).z() -= node(block.x, i).x();
  const Indentation indentation(block.triangles, block.x);
  const Vec3 normal = Vec3(1, 0, 1).normalized();
  for (const double along : {0.008, 0.013, 0.021, 0.032}) {
    const Vec3 place = Vec3(along, 0.0102, 0.020 - along) - 0.003 * normal;
    EXPECT_NEAR(indentation.at(place, normal), 0.003, kRoundoff) << along;
  }
}

TEST(Indentation, SeesTheSideThatTheNormalPointsOutOf) {
  const Mesh sheet = kuhn_block(10, 10, 1, 0.002);
  const Indentation indentation(sheet.triangles, sheet.x);
  EXPECT_NEAR(indentation.at({0.0101, 0.0077, 0.0005}, Vec3::UnitZ()), 0.0015, kRoundoff) << "the far side is nearer";
  EXPECT_TRUE(std::isnan(indentation.at({0.05, 0.05, 0.0}, Vec3::UnitZ()))) << "beside it";
  EXPECT_TRUE(std::isnan(indentation.at({0.01, 0.01, 0.0}, Vec3::Zero()))) << "no normal";
}

TEST(Indentation, EqualsALookAtEveryTriangle) {
  Mesh block = kuhn_block(6, 5, 4, 0.004);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < block.x.size(); ++i) block.x[i] += 0.0008 * unit(random);
  const Indentation indentation(block.triangles, block.x);
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 place = Vec3(0.012, 0.010, 0.008) + 0.016 * Vec3(unit(random), unit(random), unit(random));
    const Vec3 normal = Vec3(unit(random), unit(random), unit(random)).normalized();
    const double truth = every_triangle(block, place, normal), found = indentation.at(place, normal);
    ASSERT_EQ(std::isnan(truth), std::isnan(found)) << i;
    if (std::isnan(truth)) continue;
    ++met;
    ASSERT_NEAR(found, truth, kRoundoff) << i;
  }
  EXPECT_GT(met, 1000);
}

}  // namespace
}  // namespace kt
