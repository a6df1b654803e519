// A tool's mesh in millimetres is refused before anything is touched with it.
#include "haptics/setup/tool_unit.hpp"

#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

SceneTool jaw() {
  SceneTool out;
  out.shape = "mesh";
  out.mesh = KT_SOURCE_DIR "/meshes/torus.off";
  out.radius = 0.0005;
  return out;
}

TEST(ToolUnit, AMeshManyTimesTheBodyNeedsItsUnit) {
  const Vec3 sides(5, 8, 30);  // [m], of a file in millimetres
  const std::string said = message([&] { require_tool_unit(jaw(), "second_tool", sides, 0.06); });
  for (const char* word :
       {"second_tool.mesh", "torus.off", "8000 mm", "133 times", "at most 20", "second_tool.scale to mm"})
    EXPECT_NE(said.find(word), std::string::npos) << said;
  EXPECT_EQ(message([&] { require_tool_unit(jaw(), "tool", 0.1 * sides, 0.06); }), "no InputError");
}

/// A plate may be as large as one likes, and so may a mesh whose unit was given.
TEST(ToolUnit, WhatIsMeantIsTaken) {
  const Vec3 sides(5, 8, 30);
  SceneTool scaled = jaw(), sized = jaw(), ball;
  scaled.scale = 1;
  sized.size = 30;
  ball.shape = "sphere";
  for (const SceneTool& tool : {scaled, sized, ball})
    EXPECT_EQ(message([&] { require_tool_unit(tool, "tool", sides, 0.06); }), "no InputError");
}

TEST(ToolUnit, IsLookedAtBeforeTheFirstModel) {
  Scene scene = small_scene();
  const SceneTool ball = scene.tool;
  scene.tool = jaw();
  scene.tool.path = ball.path;
  scene.object.size = 0.001;
  EXPECT_NE(message([&] { Session session(scene); }).find("set tool.scale to"), std::string::npos);
  scene.second_tool = scene.tool;
  scene.tool = ball;
  scene.object.size = 0.001;
  EXPECT_NE(message([&] { Session session(scene); }).find("set second_tool.scale to"), std::string::npos);
}

}  // namespace
}  // namespace kt
