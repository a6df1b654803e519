// A loop of one's own is told what a run of the command is told, in its words: of ticks, contacts and refreshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "haptics/findings/run_findings.hpp"
#include "haptics/session/session.hpp"
#include "haptics/watch/touch_watch.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

using Lines = std::vector<std::string>;

/// What it says without its cures; empty: nothing has these words.
std::string said(const Lines& told, const std::string& words) {
  const auto at = std::ranges::find_if(told, [&](const std::string& w) { return w.find(words) != std::string::npos; });
  return at == told.end() ? "" : at->substr(0, at->find(';'));
}

const std::string kThrough = "went into the body or through it unstopped";

/// One or the other: with a patch for a tool whose speed is not known the leap drags the block with it.
bool says_it(const Lines& told) { return !(said(told, kThrough) + said(told, "contact was lost")).empty(); }

/// Above the block, and 0.4 m below in one tick. With the default friction the tool goes through; else it drags the
/// block with it.
Scene leaping_scene(bool goes_through = true) {
  Scene scene = small_scene();
  if (goes_through) scene.contact = Scene().contact;
  scene.duration = 0.2;
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = {
      {0, {0.03, 0.026, 0.2}}, {0.05, {0.03, 0.026, 0.2}}, {0.0505, {0.03, 0.026, -0.2}}, {0.2, {0.03, 0.026, -0.2}}};
  return scene;
}

/// The same by hand.
void leap(Touch& touch) {
  const Pose above{{0.03, 0.026, 0.2}}, below{{0.03, 0.026, -0.2}};
  touch.place(above);
  for (int i = 0; i < 150; ++i) touch.tick(i < 50 ? above : below);
}

/// The poses of a run again.
Lines told_of(const Scene& scene, const SessionResult& run) {
  const Session session(scene);
  TouchOptions options = session.options();
  options.tools[0].max_speed = run.tools[0].max_speed;
  Touch touch(session.body(), options);
  touch.place(run.tools[0].start);
  for (const LocalFrame& f : run.tools[0].frames) EXPECT_EQ(touch.tick(f.pose).force, f.force);
  touch.stop();  // the ticks of the last local model are looked at, too
  return lines(touch.findings());
}

/// Each of these that the command says, and how many.
int expect_same(const Scene& scene, const Lines& words) {
  Session session(scene);
  const SessionResult run = session.run();
  const Lines expected = lines(all_findings(session, run)), told = told_of(scene, run);
  int count = 0;
  for (const std::string& w : words) {
    EXPECT_EQ(said(told, w), said(expected, w));
    count += !said(expected, w).empty();
  }
  return count;
}

TEST(TouchWarnings, TellOfAToolThatWentThroughAsTheCommandDoes) {
  EXPECT_EQ(expect_same(leaping_scene(), {kThrough + " in 1 tick, first in tick 50 (t = 0.051 s), 0.4 m in that one",
                                          "contact forces were not found to within 1 %: 1 of 200 ticks"}),
            2);
}

TEST(TouchWarnings, TellOfContactThatWasLostAsTheCommandDoes) {
  EXPECT_EQ(
      expect_same(leaping_scene(false), {"contact was lost: the tool was inside the body without contact in",
                                         "mm inside the body, in", "the contact reached the edge of the local patch",
                                         "the exact tangent was indefinite at", "tetrahedra turned inside out"}),
      5);
}

TEST(TouchWarnings, TellOfItBeforeTheEndToo) {
  const Session session(leaping_scene());
  Touch touch(session.body(), session.options());
  const Pose above{{0.03, 0.026, 0.2}}, below{{0.03, 0.026, -0.2}};
  touch.place(above);
  for (int i = 0; i < 50; ++i) touch.tick(above);
  EXPECT_FALSE(says_it(lines(touch.findings())));
  for (int i = 0; i < 50; ++i) touch.tick(below);
  EXPECT_TRUE(says_it(lines(touch.findings()))) << "a refresh later";
  touch.reset();
  EXPECT_EQ(lines(touch.findings()), Lines{});
}

TEST(TouchWarnings, TellOfItInTwoThreads) {
  const Session session(leaping_scene());
  Touch touch(session.body(), session.options());
  const Pose above{{0.03, 0.026, 0.2}}, below{{0.03, 0.026, -0.2}};
  touch.place(above);
  touch.start();
  for (int i = 0; i < 200; ++i) {
    touch.tick(i < 50 ? above : below);
    touch.findings();  // from any thread: of this one as well
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  touch.stop();
  const Lines told = lines(touch.findings());
  EXPECT_NE(said(told, kThrough).find("in 1 tick, first in tick 50 (t = 0.051 s), 0.4 m"), std::string::npos)
      << ::testing::PrintToString(told);
  EXPECT_EQ(said(told, "not checked"), "");
}

TEST(TouchWarnings, AreNotOfASessionsOwnTouchNorOfWhoAsksForNone) {
  const Session session(leaping_scene());
  Touch touch(session.body(), session.options());
  touch.check_contacts(false);
  leap(touch);
  EXPECT_FALSE(says_it(lines(touch.findings())));
}

/// A method that lets tools in is not blamed for it, as by the command.
TEST(TouchWarnings, AreNotOfMethodsThatLetToolsIn) {
  Scene scene = leaping_scene();
  scene.contact.law = "paper_stick";
  const Session session(scene);
  Touch touch(session.body(), session.options());
  leap(touch);
  EXPECT_FALSE(says_it(lines(touch.findings())));
}

TEST(TouchWarnings, TellOfAToolThatStartsInsideAsTheCommandDoes) {
  Scene scene = small_scene();
  scene.duration = 0.2;
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = {{0, {0.03, 0.026, 0.019}}, {0.2, {0.03, 0.026, 0.019}}};
  Session session(scene);
  const SessionResult run = session.run();
  const Lines expected = lines(all_findings(session, run)), told = told_of(scene, run);
  for (const char* words : {"was inside the body, which was pushed off it", "mm inside the body, in"}) {
    EXPECT_NE(said(expected, words), "") << words << ::testing::PrintToString(expected);
    EXPECT_EQ(said(told, words), said(expected, words));
  }
}

TEST(TouchWarnings, TellOfTetrahedraInsideOutAsTheCommandDoes) {
  Scene scene = small_scene();
  scene.duration = 0.4;
  scene.object.model.least_volume = 0;
  scene.object.fixed.below->fraction = 0.05;
  scene.tool.path.press_drag =
      PressDrag{.at = {}, .depth = 0.006, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.05};
  Session session(scene);
  const SessionResult run = session.run();
  const std::string expected = said(lines(all_findings(session, run)), "tetrahedra turned inside out");
  EXPECT_NE(expected, "");
  EXPECT_EQ(said(told_of(scene, run), "tetrahedra turned inside out"), expected);
}

TEST(TouchWarnings, TellOfTheFlagsOfEachTool) {
  Scene scene = small_scene();
  scene.second_tool = scene.tool;
  scene.second_tool->path.press_drag->at = std::array<double, 2>{0.015, 0.026};
  const Session session(scene);
  Touch touch(session.body(), session.options());
  const std::array<Pose, 2> above{Pose{{0.03, 0.026, 0.2}}, Pose{{0.015, 0.026, 0.2}}};
  touch.place(above);
  for (int i = 0; i < 10; ++i) touch.tick(above);
  touch.tick(std::array{above[0], Pose{{NAN, 0, 0}}});
  const Lines told = lines(touch.findings());
  ASSERT_EQ(told.size(), 1u) << ::testing::PrintToString(told);
  EXPECT_NE(told[0].find("second tool: a pose that was not finite"), std::string::npos) << told[0];
  EXPECT_NE(told[0].find("1 of 11 ticks, first at t = 0.011 s"), std::string::npos) << told[0];
}

/// What contact that was lost and refreshes leave in their records.
TEST(TouchWarnings, OfRefreshesAreOfTheirRecords) {
  const Surface surface;
  TouchWatch watch(surface, {}, 1e-3, nullptr);
  std::vector<Finding> found;
  watch.tell(100, 40, 0, found);
  EXPECT_TRUE(found.empty());
  RefreshRecord record;
  record.global_ms = 1;
  record.t = 0.1;
  record.definite_tangent = true;
  record.inverted = 3;
  record.crossings = 2;
  record.pressed = 5;
  watch.refreshed(record);
  watch.tell(100, 40, 7, found);
  const Lines told = lines(found);
  for (const char* words : {"indefinite at 1 of 1 refreshes",
                            "3 of 40 tetrahedra turned inside out, first at t = 0.1 s, and 3 are at the end",
                            "the surface crossed itself, in up to 2 pairs",
                            "in up to 5 pairs of triangles: the barrier of 7 N/m is too soft"})
    EXPECT_NE(said(told, words), "") << words << ::testing::PrintToString(told);
  record = {};
  record.global_ms = 1;
  watch.refreshed(record);
  found.clear();
  watch.tell(100, 40, 7, found);
  EXPECT_NE(said(lines(found), "and came back"), "");
}

TEST(TouchWarnings, OfLostContactAreTheCommands) {
  LostContact lost;
  lost.free_ticks_inside = 4;
  const std::vector<Finding> found = lost_contact_findings(lost, 100, 1e-3, 1, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].what,
            "second tool: contact was lost: the tool was inside the body without contact in 4 of 100 ticks");
  EXPECT_EQ(found[0].weight, Finding::Weight::failure);
}

}  // namespace
}  // namespace kt
