// Fewer triangles, the same shape, no slivers.
#include "io/surface/decimate_surface.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "io/surface/surface_distance.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

/// Smallest altitude by longest edge.
double shape_of(const Mesh& mesh, const Triangle& t) {
  const Vec3 a = node(mesh.x, t[0]), b = node(mesh.x, t[1]), c = node(mesh.x, t[2]);
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return (b - a).cross(c - a).norm() / (longest * longest);
}

/// That of the flattest triangle.
double flattest(const Mesh& mesh) {
  double out = 1;
  for (const Triangle& t : mesh.triangles) out = std::min(out, shape_of(mesh, t));
  return out;
}

/// A bar with a square section of side 1 and good triangles; coarser ones have to be as long as it is thin.
Mesh bar(int length) {
  Mesh out;
  out.x.resize(12 * (length + 1));
  for (int ring = 0; ring <= length; ++ring)
    for (int i = 0; i < 4; ++i) {
      node(out.x, 4 * ring + i) = Vec3(i == 1 || i == 2 ? 1 : 0, i >= 2 ? 1 : 0, ring);
      if (ring == length) continue;
      const int a = 4 * ring + i, b = 4 * ring + (i + 1) % 4;
      out.triangles.push_back({a, b, a + 4});
      out.triangles.push_back({b, b + 4, a + 4});
    }
  const int top = 4 * length;
  for (const Triangle& t :
       {Triangle{0, 2, 1}, Triangle{0, 3, 2}, Triangle{top, top + 1, top + 2}, Triangle{top, top + 2, top + 3}})
    out.triangles.push_back(t);
  return out;
}

TEST(DecimateSurface, AFlatSidedBodyIsLeftWithoutSlivers) {
  const Mesh slab = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  const int target = static_cast<int>(slab.triangles.size() / 8);
  const Mesh coarse = decimate_surface(slab, target);
  EXPECT_LE(static_cast<int>(coarse.triangles.size()), target);
  EXPECT_GT(static_cast<int>(coarse.triangles.size()), target - 4);
  EXPECT_GE(flattest(coarse), 0.2);
  EXPECT_NEAR(enclosed_volume(coarse), enclosed_volume(slab), 1e-9 * enclosed_volume(slab));  // its corners stay
}

TEST(DecimateSurface, CurvedBodiesKeepTheirShapeAndHandles) {
  for (const char* name : {"torus.off", "genus5.off", "sphere.off"}) {
    const Mesh fine = load_mesh(std::string(KT_SOURCE_DIR "/meshes/") + name);
    const int target = static_cast<int>(fine.triangles.size() / 2);
    const Mesh coarse = decimate_surface(fine, target);
    EXPECT_LE(static_cast<int>(coarse.triangles.size()), target) << name;
    EXPECT_TRUE(examine(coarse).clean()) << name;
    EXPECT_EQ(examine(coarse).euler, examine(fine).euler) << name;
    EXPECT_GE(flattest(coarse), std::min(0.2, flattest(fine))) << name;
    const double size = (fine.x.maxCoeff() - fine.x.minCoeff());
    EXPECT_LT(hausdorff_distance(fine, coarse, size / 100), 0.02 * size) << name;
  }
}

TEST(DecimateSurface, WhatIsThinGetsDownToTheNumberWithFlatterOnes) {
  const Mesh fine = bar(100);
  EXPECT_GT(flattest(fine), 0.45);
  const Mesh coarse = decimate_surface(fine, 40);
  EXPECT_LE(coarse.triangles.size(), 40u);
  EXPECT_TRUE(examine(coarse).clean());
  EXPECT_NEAR(enclosed_volume(coarse), 100, 1e-9);
}

/// On a flat face every collapse costs nothing, and plain quadrics leave the needles that came.
TEST(DecimateSurface, EvenlyLeavesNoNeedlesOnFlatFaces) {
  const Mesh disc = thin_disc(100);
  const auto median_shape = [](const Mesh& mesh) {
    std::vector<double> shapes;
    for (const Triangle& t : mesh.triangles) shapes.push_back(shape_of(mesh, t));
    std::ranges::sort(shapes);
    return shapes[shapes.size() / 2];
  };
  const Mesh plain = decimate_surface(disc, 297), even = decimate_surface(disc, 297, {.evenly = true});
  EXPECT_LT(median_shape(plain), 0.3);
  EXPECT_GT(median_shape(even), 0.4);
  EXPECT_LE(even.triangles.size(), 297u);
  EXPECT_TRUE(examine(even).clean());
  EXPECT_LT(hausdorff_distance(disc, even, 2e-3), 5e-4);  // a quarter of its thickness
  EXPECT_NEAR(enclosed_volume(even), enclosed_volume(disc), 5e-3 * enclosed_volume(disc));
}

TEST(DecimateSurface, ThreeTrianglesAtAnEdgeAndTooLittleTimeAreErrors) {
  const Mesh bad = load_mesh(KT_SOURCE_DIR "/meshes/broken/nonmanifold_edge.off", {.lenient = true});
  EXPECT_THROW(decimate_surface(bad, 4), RunError);
  const Mesh fine = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  EXPECT_THROW(decimate_surface(fine, 10, {.timeout = 1e-3}), RunError);
}

}  // namespace
}  // namespace kt
