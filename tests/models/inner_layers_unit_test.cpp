#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "io/mesh/mesh_io.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

Mesh sphere() { return load_mesh(KT_SOURCE_DIR "/meshes/sphere.off"); }  // radius 0.03 m

TEST(InnerLayers, FillTheShellBelowASphere) {
  constexpr double kThickness = 0.01, kRoundoff = 1e-12;
  const Mesh surface = sphere();
  const Mesh shell = add_inner_layers(surface, 2, kThickness);
  EXPECT_EQ(shell.num_nodes(), 3 * surface.num_nodes());
  EXPECT_EQ(shell.tetrahedra.size(), 2 * 3 * surface.triangles.size());
  EXPECT_EQ(shell.triangles, surface.triangles);
  double volume = 0;
  for (const Tetrahedron& t : shell.tetrahedra) {
    EXPECT_GT(tetrahedron_volume(shell.x, t), 0);
    volume += tetrahedron_volume(shell.x, t);
  }
  // The innermost layer is the surface scaled by 20 mm / 30 mm.
  EXPECT_NEAR(volume, enclosed_volume(surface) * (1 - 8.0 / 27), 1e-3 * volume);
  Mesh inner = surface;
  inner.x = shell.x.tail(surface.x.size());
  EXPECT_NEAR(volume, enclosed_volume(surface) - enclosed_volume(inner), kRoundoff);
}

TEST(InnerLayers, ThatFoldAreRefused) { EXPECT_THROW(add_inner_layers(sphere(), 1, 0.05), InputError); }

}  // namespace
}  // namespace kt
