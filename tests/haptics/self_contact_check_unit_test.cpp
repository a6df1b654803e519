// A folded body that is clamped runs; what cannot be kept apart is refused.
#include "haptics/self_contact_check.hpp"

#include <gtest/gtest.h>

#include "bench/pressed_bodies.hpp"
#include "haptics/session.hpp"
#include "io/mesh_doctor.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

Mesh two_blocks(double gap) {
  const Mesh block = kuhn_block(4, 4, 2, 0.005);
  return joined({block, placed(block, {0.001, 0.002, 0.01 + gap})});
}

TEST(SelfContactCheck, RefusesAPieceThatNothingHolds) {
  const Mesh mesh = two_blocks(1e-3);
  EXPECT_THROW(check_self_contact(mesh, {0, 1, 2}), InputError);
  EXPECT_NO_THROW(check_self_contact(mesh, {0, mesh.num_nodes() - 1}));
}

#if KT_WITH_CGAL
TEST(SelfContactCheck, RefusesASurfaceThatPassesThroughItself) {
  const Mesh mesh = two_blocks(-1e-3);
  EXPECT_THROW(check_self_contact(mesh, {0, mesh.num_nodes() - 1}), InputError);
}
#endif

/// The upper block, clamped at one end, is pressed onto the lower one.
SessionResult pressed(bool self_contact, Mesh& end) {
  Scene scene;
  scene.duration = 0.6;
  scene.object.fixed.below.reset();
  scene.object.model.type = "fem";
  scene.object.model.young = 2e4;
  scene.object.model.damping.stiffness = 2e-3;
  scene.global.integrator = "newton_euler";
  scene.local.reducer = "condensed";
  scene.tool.path.press_drag->depth = 0.004;
  scene.tool.path.press_drag->speed = 0.01;
  if (self_contact) scene.object.self_contact = SceneSelfContact{};
  const Mesh block = kuhn_block(8, 4, 2, 0.005);
  Mesh mesh = joined({block, placed(block, {0.001, 0.0002, 0.0115})});
  scene.object.fixed.nodes = std::vector<int>{};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9 || mesh.x[3 * i] < 1e-9 || (i >= block.num_nodes() && mesh.x[3 * i] < 0.0015))
      scene.object.fixed.nodes->push_back(i);
  end = mesh;
  Session session(scene, std::move(mesh));
  SessionResult run = session.run({.snapshot_times = {0.6}});
  end.x = run.snapshots.back().x;
  return run;
}

TEST(SelfContact, KeepsAPressedBlockOutOfTheOneBelow) {
  Mesh with, without;
  const SessionResult run = pressed(true, with);
  pressed(false, without);
  EXPECT_EQ(run.missed_impacts, 0);
#if KT_WITH_CGAL
  bool complete = false;
  EXPECT_TRUE(find_self_intersections(with, 10, complete).empty());
  EXPECT_FALSE(find_self_intersections(without, 10, complete).empty());
#endif
}

}  // namespace
}  // namespace kt
