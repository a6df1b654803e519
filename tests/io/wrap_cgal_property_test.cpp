// Filling holes and wrapping: the result is clean, and what is said about it is true.
#include "io/surface/mesh_doctor.hpp"
#include "io/surface/mesh_repair.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

TEST(FillHoles, ASmallHoleIsClosedAndALargeOneIsLeft) {
  const Mesh open = load_mesh(KT_SOURCE_DIR "/meshes/broken/open.off");
  EXPECT_EQ(examine(repair(open, {.fill_holes = 2}).mesh).open_edges.size(), 3u);
  const RepairResult r = repair(open, {.fill_holes = 3});
  EXPECT_TRUE(examine(r.mesh).clean());
  EXPECT_NEAR(enclosed_volume(r.mesh), 8e-6, 1e-18);
  EXPECT_EQ(r.done.back(), "1 holes of at most 3 edges closed");
}

TEST(Wrap, EveryBrokenSurfaceBecomesCleanAndNear) {
  for (const char* name :
       {"open.off", "self_intersecting.off", "nonmanifold_edge.off", "duplicate_degenerate.off", "nan.off"}) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/broken/") + name, {.lenient = true});
    const WrapResult w = wrap(mesh, {.alpha = 0.003, .offset = 0.0003});
    EXPECT_TRUE(examine(w.mesh).clean()) << name;
    EXPECT_GT(w.volume_after, 0) << name;
    EXPECT_LT(w.distance_to_input, 0.003) << name;  // the wrap stays within about alpha of the input
  }
}

TEST(Wrap, ReportsTheChangeOfVolume) {
  const Mesh sphere = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  const WrapResult w = wrap(sphere, {.alpha = 0.004, .offset = 0.0006});
  EXPECT_EQ(w.volume_before, enclosed_volume(sphere));
  EXPECT_EQ(w.volume_after, enclosed_volume(w.mesh));
  EXPECT_GT(w.volume_after, w.volume_before);  // 0.6 mm outside a sphere of 30 mm: about 6 %
  EXPECT_LT(w.volume_after, 1.12 * w.volume_before);
  EXPECT_NEAR(w.distance_to_wrap, 0.0006, 0.0003);
  EXPECT_NEAR(w.distance_to_input, 0.0006, 0.0003);
}

TEST(Wrap, TimeIsLimited) {
  const Mesh sphere = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  EXPECT_THROW(wrap(sphere, {.alpha = 0.0002, .timeout = 0.05}), RunError);
}

}  // namespace
}  // namespace kt
