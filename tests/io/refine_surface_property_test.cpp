// Splitting edges near a place changes neither the shape nor what closes it.
#include <gtest/gtest.h>

#include <set>

#include "core/base/error.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/surface/refine_surface.hpp"

namespace kt {
namespace {

Mesh sphere() { return load_mesh(KT_SOURCE_DIR "/meshes/sphere.off"); }

TEST(RefineSurface, KeepsVolumeAndStaysClosed) {
  const Mesh before = sphere();
  const Vec3 top = node(before.x, 0);
  const Mesh after = refine_surface(before, {top, 0.005, 0.001}, 20000);
  EXPECT_GT(after.num_nodes(), before.num_nodes());
  EXPECT_NEAR(enclosed_volume(after), enclosed_volume(before), 1e-12 * enclosed_volume(before));
  // Every edge once in each direction.
  std::set<std::pair<int, int>> edges;
  for (const Triangle& t : after.triangles)
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.insert({t[k], t[(k + 1) % 3]}).second);
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
  EXPECT_EQ(after.x.head(before.x.size()), before.x);
}

TEST(RefineSurface, NoEdgeIsLongerThanWantedAndFarOnesAreLeft) {
  const Mesh before = sphere();
  const SurfaceSize size{node(before.x, 0), 0.005, 0.001};
  const Mesh after = refine_surface(before, size, 20000);
  for (const Triangle& t : after.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = node(after.x, t[k]), b = node(after.x, t[(k + 1) % 3]);
      const double away = std::max(0.0, (0.5 * (a + b) - size.centre).norm() - 0.5 * (a - b).norm() - size.radius);
      EXPECT_LE((a - b).norm(), size.edge + size.growth * away);
    }
  const Mesh unchanged = refine_surface(before, {size.centre, 0.005, 1}, 20000);
  EXPECT_EQ(unchanged, before);
}

TEST(RefineSurface, MoreNodesThanAllowedAreAnError) {
  const Mesh before = sphere();
  EXPECT_THROW(refine_surface(before, {node(before.x, 0), 0.01, 1e-4}, before.num_nodes() + 100), RunError);
}

}  // namespace
}  // namespace kt
