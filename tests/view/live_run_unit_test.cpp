// What a page is told of a body before it runs.
#include "view/live_run.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

LiveRun run_of(const Scene& scene) { return {scene, true, {}, {}, {}}; }

TEST(LiveRun, SettingsAreThereBeforeTheFirstModel) {
  Scene scene = small_scene();
  scene.contact.mu_static = 0.5;
  scene.contact.mu_kinetic = 0.3;
  const LiveRun run = run_of(scene);
  for (const LiveSetting& s : live_settings()) EXPECT_NE(run.setting(s.key), "") << s.key;
  EXPECT_EQ(run.setting("contact.mu_static"), "0.5");
  EXPECT_EQ(run.setting("contact.mu_kinetic"), "0.3");
  EXPECT_EQ(run.setting("object.model.young"), text(scene.object.model.young));
  EXPECT_EQ(run.setting("local.reducer"), scene.local.reducer);
}

TEST(LiveRun, WhatIsSetBeforeTheFirstModelIsShownAndLookedAt) {
  LiveRun run = run_of(small_scene());
  run.set("contact.mu", "0.9");
  run.set("object.model.young", "20000");
  run.set("local.reducer", "wall");
  EXPECT_EQ(run.setting("contact.mu_kinetic"), "0.9");
  EXPECT_EQ(run.setting("object.model.young"), "20000");
  EXPECT_EQ(run.setting("local.reducer"), "wall");
  EXPECT_THROW(run.set("contact.mu", "-1"), InputError);
  EXPECT_THROW(run.set("local.reducer", "magic"), InputError);
  EXPECT_EQ(run.setting("contact.mu_static"), "0.9");
}

}  // namespace
}  // namespace kt
