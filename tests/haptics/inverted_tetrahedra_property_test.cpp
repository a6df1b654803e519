// Runs say how many tetrahedra turned inside out: springs let them, unless their volumes are guarded.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/findings/run_findings.hpp"

namespace kt {
namespace {

struct Pressed {
  RefreshRun refresh;
  std::vector<std::string> told;
};

Pressed pressed(const std::string& model, double depth, double least_volume) {
  Scene scene;
  scene.duration = 0.4;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/block.msh";
  scene.object.model.type = model;
  scene.object.model.least_volume = least_volume;
  scene.object.fixed.below->fraction = 0.05;
  scene.local.reducer = "condensed";
  scene.tool.path.press_drag =
      PressDrag{.at = {}, .depth = depth, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.05};
  Session session(scene);
  const SessionResult run = session.run();
  return {run.refresh, lines(all_findings(session, run))};
}

bool warns_of(const Pressed& run, const std::string& words) {
  return std::ranges::any_of(run.told, [&](const std::string& w) {
    return w.find("turned inside out") != std::string::npos && w.find(words) != std::string::npos;
  });
}

bool warns(const Pressed& run) { return warns_of(run, ""); }

TEST(InvertedTetrahedra, AreCountedAndToldOfUnguardedSprings) {
  const Pressed run = pressed("msd", 0.006, 0);
  EXPECT_GT(run.refresh.inverted.most, 0);
  EXPECT_LE(run.refresh.inverted.last, run.refresh.inverted.most);
  EXPECT_GT(run.refresh.inverted.from, 0.05);  // not before the tool has come
  EXPECT_TRUE(warns(run));
  EXPECT_EQ(warns_of(run, text(", and ", run.refresh.inverted.last, " are at the end")), run.refresh.inverted.last > 0);
  EXPECT_EQ(warns_of(run, "came back"), run.refresh.inverted.last == 0);
}

TEST(InvertedTetrahedra, AreNoneInGuardedSpringsPressedAsDeep) {
  const Pressed run = pressed("msd", 0.006, Scene().object.model.least_volume);
  EXPECT_EQ(run.refresh.inverted.most, 0);
  EXPECT_FALSE(warns(run));
}

TEST(InvertedTetrahedra, AreNoneWhereTheBodyIsHardlyPressed) {
  const Pressed run = pressed("fem", 0.001, 0);
  EXPECT_EQ(run.refresh.inverted.most, 0);
  EXPECT_EQ(run.refresh.inverted.last, 0);
  EXPECT_FALSE(warns(run));
}

}  // namespace
}  // namespace kt
