// What a run says of pieces that nothing holds, and of nodes that coincide and are not shared.
#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.01;  // [m]

/// Blocks of 2 x 2 x 1 cells, their nodes their own, each moved.
Mesh blocks(const std::vector<Vec3>& places) {
  const Mesh one = kuhn_block(2, 2, 1, kCell);
  Mesh out;
  out.x.resize(static_cast<Eigen::Index>(places.size()) * one.x.size());
  for (std::size_t b = 0; b < places.size(); ++b) {
    const int first = static_cast<int>(b) * one.num_nodes();
    for (int i = 0; i < one.num_nodes(); ++i) node(out.x, first + i) = node(one.x, i) + places[b];
    for (Tetrahedron t : one.tetrahedra) {
      for (int& i : t) i += first;
      out.tetrahedra.push_back(t);
    }
  }
  out.triangles = boundary_triangles(out.tetrahedra);
  return out;
}

/// Of `pieces` only.
std::vector<std::string> said(const Mesh& body, const SceneFixed& fixed) {
  Scene scene = small_scene();
  scene.object.model.type = "fem";
  scene.object.fixed = fixed;
  scene.tool.path = {.press_drag = {},
                     .waypoints = std::vector<Waypoint>{{0, Vec3(0.01, 0.01, 0.1)}},
                     .recording = {},
                     .hand = {},
                     .device = {}};
  const Session session(scene, body);
  std::vector<std::string> out;
  for (const Prediction& p : session.predictions())
    if (p.failure == "pieces") out.push_back(p.message());
  return out;
}

SceneFixed nodes(std::vector<int> held) { return {.below = {}, .box = {}, .nodes = std::move(held)}; }

bool holds(const std::string& line, const std::string& words) { return line.find(words) != std::string::npos; }

TEST(FreePieces, AreNamedWithTheirPlace) {
  const SceneFixed below{.below = FixedBelow{"z", 0.05}, .box = {}, .nodes = {}};
  EXPECT_TRUE(said(blocks({Vec3::Zero()}), below).empty());
  EXPECT_TRUE(said(blocks({Vec3::Zero(), Vec3(0.05, 0, 0)}), below).empty());  // both stand on the ground
  const auto apart = said(blocks({Vec3::Zero(), Vec3(0, 0, 0.03)}), below);
  ASSERT_EQ(apart.size(), 1u) << testing::PrintToString(apart);
  for (const char* words : {"object.fixed: a piece of 18 nodes of 36, from (0, 0, 0.03) to (0.02, 0.02, 0.04) m, is "
                            "held by nothing and drifts off",
                            "clamp some of it"})
    EXPECT_TRUE(holds(apart[0], words)) << apart[0];
  EXPECT_FALSE(holds(apart[0], "--weld")) << apart[0];
}

TEST(FreePieces, OfALayerThatOnlyLiesOnAnotherAreCuredByWelding) {
  const auto layers =
      said(blocks({Vec3::Zero(), Vec3(0, 0, kCell)}), {.below = FixedBelow{"z", 0.05}, .box = {}, .nodes = {}});
  ASSERT_EQ(layers.size(), 2u) << testing::PrintToString(layers);
  EXPECT_TRUE(
      holds(layers[0], "object.mesh: at 9 places nodes coincide and are not shared, the first at (0, 0, 0.01)"));
  for (const std::string& line : layers)
    EXPECT_TRUE(holds(line, "kilotouch mesh repair ") && holds(line, "--weld TOL"));
  EXPECT_TRUE(holds(layers[1], "held by nothing"));
}

TEST(FreePieces, ABodyHeldOnOneLineTurns) {
  const auto hinge = said(blocks({Vec3::Zero()}), nodes({0, 1, 2}));
  ASSERT_EQ(hinge.size(), 1u);
  EXPECT_TRUE(holds(hinge[0], "is held at 3 nodes only, on one line, and turns about it")) << hinge[0];
  EXPECT_TRUE(said(blocks({Vec3::Zero()}), nodes({0, 1, 3})).empty());
}

}  // namespace
}  // namespace kt
