// Holes of surfaces as loops of edges.
#include "io/surface/border_loops.hpp"

#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

TEST(BorderLoops, OneHoleIsOneLoop) {
  EXPECT_TRUE(find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/torus.off")).empty());
  const std::vector<BorderLoop> loops = find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/broken/open.off"));
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].nodes.size(), 3u);
  EXPECT_NEAR(loops[0].length, 0.04 + 0.02 * std::sqrt(2.0), 1e-15);
}

TEST(BorderLoops, HoldAllOpenEdgesOfManifoldMeshes) {
  if (real_meshes().empty()) GTEST_SKIP() << kNoMeshes;
  for (const std::string& f : real_meshes()) {
    const Mesh mesh = load_mesh(f);
    const MeshReport r = examine(mesh, {.self_intersections = false});
    if (!r.manifold() || !r.flipped.empty() || !r.one_sided.empty()) continue;
    std::size_t edges = 0;
    for (const BorderLoop& l : find_border_loops(mesh)) edges += l.nodes.size();
    if (r.degenerate.empty()) {
      EXPECT_EQ(edges, r.open_edges.size()) << f;
    }
  }
}

}  // namespace
}  // namespace kt
