// The winding number by a tree against the sum over all triangles, and against what is inside of a ball.
#include "io/surface/winding_number.hpp"

#include <gtest/gtest.h>

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
      const double exact = winding_number(mesh, place);
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

}  // namespace
}  // namespace kt
