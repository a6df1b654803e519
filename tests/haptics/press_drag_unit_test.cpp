#include "haptics/device/press_drag.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "io/mesh_io.hpp"

namespace kt {
namespace {

const ToolShape kPoint{ToolShape::Kind::point, 0}, kSphere{ToolShape::Kind::sphere, 0.004};
constexpr double kTop = 0.03;       // [m] of the slab, 0.1 x 0.1 m
constexpr double kRounding = 1e-9;  // [m] the narrow phase may stop this much short

Mesh slab() { return load_mesh(KT_SOURCE_DIR "/meshes/slab_coarse.off"); }

TEST(DropTool, TouchesWhereTheShapeTouches) {
  EXPECT_NEAR(drop_tool(slab(), kPoint, 2, {0.052, 0.047, 9})->z(), kTop, kRounding);
  EXPECT_NEAR(drop_tool(slab(), kSphere, 2, {0.052, 0.047, 9})->z(), kTop + 0.004, kRounding);
  EXPECT_FALSE(drop_tool(slab(), kPoint, 2, {0.2, 0.05, 0}).has_value());
  // Beside the slab by half a radius: the edge is touched, sqrt(3)/2 of a radius above it.
  EXPECT_NEAR(drop_tool(slab(), kSphere, 2, {0.102, 0.05, 0})->z(), kTop + 0.004 * std::sqrt(0.75), kRounding);
}

TEST(DropTool, FindsTheTopOfASphere) {
  const Mesh ball = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  const auto touch = drop_tool(ball, kSphere, 0, {0, 0, 0});
  ASSERT_TRUE(touch);
  EXPECT_NEAR(touch->x(), 0.034, 2e-4) << "the icosphere is a little smaller than its sphere";
}

TEST(PressDrag, ComesDownPressesAndDragsAtConstantDepthAndSpeed) {
  PressDragOptions o;
  o.at = {{0.03, 0.05}};
  const auto path = make_press_drag(slab(), kSphere, o);
  EXPECT_EQ(path.front().t, 0);
  EXPECT_NEAR(path.front().x.z(), kTop + 0.004 + o.clearance, kRounding);
  EXPECT_EQ(path[1].t, o.press_time);
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_NEAR(path[i].x.z(), kTop + 0.004 - o.depth, kRounding);
    EXPECT_NEAR(path[i].x.y(), 0.05, kRounding);
    if (i > 1) {
      EXPECT_NEAR((path[i].x - path[i - 1].x).norm() / (path[i].t - path[i - 1].t), o.speed, 1e-6);
    }
  }
  EXPECT_GE(path.back().t, o.duration);
  EXPECT_NEAR(interpolate_path(path, 0.6).x(), 0.03 + 0.05 * 0.4, 1e-6);
}

TEST(PressDrag, TurnsRoundWhereTheSurfaceEnds) {
  PressDragOptions o;
  o.at = {{0.09, 0.05}};
  o.duration = 2;
  const auto path = make_press_drag(slab(), kPoint, o);
  double highest = 0;
  for (const TimedPoint& p : path) highest = std::max(highest, p.x.x());
  EXPECT_LE(highest, 0.1 + kRounding);
  EXPECT_GE(highest, 0.0995);
  EXPECT_LT(interpolate_path(path, 0.2 + 0.25).x(), highest - 0.001) << "on its way back";
}

TEST(PressDrag, ChoosesAPlaceOnTheBody) {
  for (const char* name : {"sphere", "torus", "genus5"}) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/") + name + ".off");
    const auto path = make_press_drag(mesh, kSphere, PressDragOptions{.at = {}, .depth = 0.001});
    EXPECT_GT(path.size(), 10u) << name;
    EXPECT_LE(path_speed(path), 0.05 * std::sqrt(1 + 0.6 * 0.6) * (1 + 1e-6)) << name << ": no steeper than 31 degrees";
  }
}

TEST(PressDrag, RefusesPlacesBesideTheBodyAndDirectionsAlongTheAxis) {
  EXPECT_THROW(make_press_drag(slab(), kPoint, {.at = {{0.5, 0.5}}}), InputError);
  EXPECT_THROW(make_press_drag(slab(), kPoint, {.at = {}, .direction = {0, 0, 1}}), InputError);
}

}  // namespace
}  // namespace kt
