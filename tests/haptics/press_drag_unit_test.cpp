#include "haptics/device/press_drag.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {
namespace {

const ToolShape kPoint{ToolShape::Kind::point, 0}, kSphere{ToolShape::Kind::sphere, 0.004};
constexpr double kTop = 0.03;       // [m] of the slab, 0.1 x 0.1 m
constexpr double kRounding = 1e-9;  // [m] the narrow phase may stop this much short

Mesh slab() { return load_mesh(KT_SOURCE_DIR "/meshes/slab_coarse.off"); }

/// Coordinate of the tool at first touch.
double touch_height(const Mesh& mesh, const ToolShape& tool, int axis, const std::array<double, 2>& at) {
  PressDragOptions o;
  o.axis = axis;
  o.at = at;
  o.direction = Vec3::Unit((axis + 1) % 3);
  o.clearance = 0;
  return make_press_drag(mesh, tool, o).front().x[axis];
}

TEST(PressDrag, TouchesWhereTheShapeTouches) {
  EXPECT_NEAR(touch_height(slab(), kPoint, 2, {0.052, 0.047}), kTop, kRounding);
  EXPECT_NEAR(touch_height(slab(), kSphere, 2, {0.052, 0.047}), kTop + 0.004, kRounding);
  EXPECT_THROW(touch_height(slab(), kPoint, 2, {0.2, 0.05}), InputError);
  // Beside the slab by half a radius: the edge is touched, sqrt(3)/2 of a radius above it.
  EXPECT_NEAR(touch_height(slab(), kSphere, 2, {0.102, 0.05}), kTop + 0.004 * std::sqrt(0.75), kRounding);
}

TEST(PressDrag, FindsTheTopOfASphere) {
  const Mesh ball = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  EXPECT_NEAR(touch_height(ball, kSphere, 0, {0, 0}), 0.034, 2e-4)
      << "the icosphere is a little smaller than its sphere";
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

TEST(PressDrag, EasedItStartsTurnsAndStopsWithoutAKink) {
  PressDragOptions o;
  o.at = {{0.08, 0.05}};
  o.eased = true;
  o.duration = 2.5;
  const auto path = make_press_drag(slab(), kPoint, o);
  EXPECT_GE(path.back().t, o.duration);
  EXPECT_NEAR(path.front().x.z(), kTop + o.clearance, kRounding);
  EXPECT_NEAR(interpolate_path(path, o.press_time).z(), kTop - o.depth, kRounding);
  // Half-way in time it is half-way down, at 15/8 of the mean speed.
  EXPECT_NEAR(interpolate_path(path, o.press_time / 2).z(), kTop + (o.clearance - o.depth) / 2, kRounding);
  double fastest_down = 0, fastest = 0, jerkiest = 0, highest = 0;
  for (std::size_t i = 2; i < path.size(); ++i) {
    const Vec3 before = (path[i - 1].x - path[i - 2].x) / (path[i - 1].t - path[i - 2].t);
    const Vec3 after = (path[i].x - path[i - 1].x) / (path[i].t - path[i - 1].t);
    const bool presses = path[i].t <= o.press_time;
    (presses ? fastest_down : fastest) = std::max(presses ? fastest_down : fastest, after.norm());
    jerkiest = std::max(jerkiest, (after - before).norm());
    highest = std::max(highest, path[i].x.x());
  }
  EXPECT_NEAR(fastest_down, 15.0 / 8 * (o.clearance + o.depth) / o.press_time, 1e-4);
  EXPECT_NEAR(fastest, o.speed, 1e-6);
  // Most acceleration: of the press 10 / sqrt(3) way / time^2, of the ramp 1.5 speed / ramp; in steps of 1 ms.
  EXPECT_LT(jerkiest,
            1.01e-3 * std::max(5.7735 * (o.clearance + o.depth) / (o.press_time * o.press_time), 1.5 * o.speed / 0.1));
  // 0.1 s of its speed are half the way: the drag is late by 0.05 s.
  EXPECT_NEAR(interpolate_path(path, o.press_time + 0.15).x(), 0.08 + o.speed * 0.1, 1e-6);
  EXPECT_LE(highest, 0.1 + kRounding);
  EXPECT_GT(highest, 0.0994);
  EXPECT_LT(path.back().x.x(), highest - 0.005) << "on its way back";
}

TEST(PressDrag, EasedItFollowsShortDragsAndNone) {
  PressDragOptions o;
  o.eased = true;
  o.at = {{0.103, 0.05}};  // 1 mm of surface is left
  for (const double speed : {0.0, 1e-3, 0.05, 1.0}) {
    o.speed = speed;
    const auto path = make_press_drag(slab(), kSphere, o);
    for (const TimedPoint& p : path) ASSERT_TRUE(p.x.allFinite());
    EXPECT_LE(path_speed(path), std::max(1.2 * speed, 15.0 / 8 * (o.clearance + o.depth) / o.press_time * 1.001));
  }
}

TEST(PressDrag, AChosenPlaceStaysClearOfAnotherTool) {
  PressDragOptions o;
  const auto first = make_press_drag(slab(), kSphere, o);
  o.other = first;
  o.apart = 0.016;
  const auto second = make_press_drag(slab(), kSphere, o);
  EXPECT_GE(least_distance(first, second), o.apart);
  EXPECT_EQ(least_distance(first, first), 0);
  o.apart = 1;
  EXPECT_THROW(make_press_drag(slab(), kSphere, o), InputError) << "larger than the body";
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
