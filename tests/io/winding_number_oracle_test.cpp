// The winding number by a tree against the sum over all triangles, and against what is inside of a ball.
#include "io/surface/winding_number.hpp"

#include <gtest/gtest.h>

#include "collision/shape/closest_point.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

TEST(WindingNumber, IsThatOfAllTriangles) {
  for (const char* name : {"organ.off", "genus5.off", "sphere.off"}) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/") + name);
    const WindingNumber winding(mesh);
    const Bounds box = bounds(mesh);
    Sample sample{std::mt19937_64(3)};
    double most = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 place = box.centre() + 1.2 * box.size().cwiseProduct(sample.cube());
      const double exact = winding_number(mesh.x, mesh.triangles, place);
      most = std::max(most, std::abs(winding.at(place) - exact));
      EXPECT_NEAR(exact, std::round(exact), 1e-9) << name;
      EXPECT_EQ(winding.is_inside(place), exact > 0.5) << name;
    }
    EXPECT_LT(most, 0.1) << name;
  }
}

TEST(WindingNumber, OfAnOpenSurfaceIsTheSolidAngle) {
  Mesh half;  // the unit square at z = 0: seen from its middle it fills half of the view
  half.x.resize(12);
  half.x << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0;
  half.triangles = {{0, 1, 2}, {0, 2, 3}};
  const WindingNumber winding(half);
  EXPECT_NEAR(winding.at(Vec3(0, 0, -1e-9)), 0.5, 1e-6);
  EXPECT_NEAR(winding.at(Vec3(0, 0, 1e-9)), -0.5, 1e-6);
  // Of a cube around the place the square would be one of six faces.
  EXPECT_NEAR(winding.at(Vec3(0, 0, -1)), 1.0 / 6, 1e-6);
}

/// Against all triangles one by one, by a function of its own.
TEST(WindingNumber, KnowsTheNearestTriangle) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/organ.off");
  const WindingNumber winding(mesh);
  const Bounds box = bounds(mesh);
  Sample sample{std::mt19937_64(4)};
  for (int i = 0; i < 300; ++i) {
    const Vec3 place = box.centre() + 0.7 * box.size().cwiseProduct(sample.cube());
    double truth = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles) {
      const Vec3 a = node(mesh.x, t[0]), b = node(mesh.x, t[1]), c = node(mesh.x, t[2]);
      truth = std::min(truth, (closest_point_on_triangle(place, a, b, c).point - place).norm());
    }
    const double rounding = 1e-12 * box.size().norm();
    EXPECT_NEAR(winding.distance(place, 1.001 * truth), truth, rounding);
    EXPECT_NEAR(winding.distance(place, 1e3 * truth), truth, rounding);
    EXPECT_EQ(winding.distance(place, 0.999 * truth), 0.999 * truth);
    EXPECT_FALSE(winding.nearest(place, 0.999 * truth));
    const auto nearest = winding.nearest(place, 1.001 * truth);
    ASSERT_TRUE(nearest);
    EXPECT_NEAR((*nearest - place).norm(), truth, rounding);
    EXPECT_NEAR(winding.distance(*nearest, truth), 0, rounding);  // on the surface
  }
}

/// Two blocks a thousandth apart, and two that overlap.
TEST(WindingNumber, PartsWhatAGapLiesBetween) {
  const auto boxes = [](double from, double to) {
    Mesh low = kuhn_block(2, 2, 2, 0.5), high = low;
    for (int i = 0; i < high.num_nodes(); ++i) high.x[3 * i + 2] = from + (to - from) * high.x[3 * i + 2];
    Mesh out{VectorX(low.x.size() + high.x.size()), low.triangles, {}};
    out.x << low.x, high.x;
    for (const Triangle& t : high.triangles)
      out.triangles.push_back({t[0] + low.num_nodes(), t[1] + low.num_nodes(), t[2] + low.num_nodes()});
    return out;
  };
  const Vec3 below(0.43, 0.37, 0.9), above(0.47, 0.41, 1.1);
  const Mesh apart = boxes(1.001, 2), overlapping = boxes(0.95, 2);
  EXPECT_TRUE(WindingNumber(apart).parts(below, above));
  EXPECT_TRUE(WindingNumber(apart).parts(above, below));
  EXPECT_FALSE(WindingNumber(apart).parts(below, Vec3(0.2, 0.8, 0.1)));
  EXPECT_FALSE(WindingNumber(overlapping).parts(below, above));
}

}  // namespace
}  // namespace kt
