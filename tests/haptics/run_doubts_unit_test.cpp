#include "haptics/study/run_doubts.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

ForceMetrics calm() { return {.mean_n = 1, .max_n = 2, .ticks_stick = 100}; }

void expect_one(const std::vector<Doubt>& doubts, const std::string& what, const std::string& cure) {
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_NE(doubts[0].what.find(what), std::string::npos) << doubts[0].what;
  EXPECT_NE(doubts[0].cure.find(cure), std::string::npos) << doubts[0].cure;
}

TEST(RunDoubts, AreNoneOfASteadyForce) { EXPECT_TRUE(find_doubts(calm(), Scene{}).empty()); }

TEST(RunDoubts, NameJumpsAtEdgesWithTheirCure) {
  ForceMetrics f = calm();
  f.crossing_jump = 0.6;
  expect_one(find_doubts(f, Scene{}), "jumps by up to 60 % of its mean in one tick at an edge",
             "contact.surface to loop");
  Scene smooth;
  smooth.contact.surface = "loop";
  expect_one(find_doubts(f, smooth), "60 %", "object.tetrahedralize.max_edge");
}

TEST(RunDoubts, NameJumpsAtRefreshesBuzzAndLostContacts) {
  ForceMetrics f = calm();
  f.refresh_jump = 0.3;
  expect_one(find_doubts(f, Scene{}), "30 %", "global.rate_hz to 60");
  Scene sharp;
  sharp.local.blend_ms = 0;
  expect_one(find_doubts(f, sharp), "30 %", "local.blend_ms to 12");
  f = calm();
  f.buzz = 0.2;
  expect_one(find_doubts(f, Scene{}), "above 100 Hz by 20 %", "damping");
  f = calm();
  f.lost_contacts = 3;
  expect_one(find_doubts(f, Scene{}), "ended 3 times", "global.rate_hz");
  Scene paper;
  paper.contact.law = "paper_stick";
  expect_one(find_doubts(f, paper), "ended 3 times", "contact.law to coulomb");
}

TEST(RunDoubts, SayThatTheToolNeverTouched) {
  ForceMetrics f;
  f.ticks_free = 100;
  expect_one(find_doubts(f, Scene{}), "never touched", "tool.path");
}

TEST(RunDoubts, TakeWarningsApartAndLeaveNotesOut) {
  SessionResult result;
  result.notes = {"object.repair: 3 triangles turned"};
  const std::vector<std::string> warnings{"object.repair: 3 triangles turned",
                                          "elements turned; at the end; press less deep"};
  const auto doubts = find_doubts(Scene{}, result, warnings, {calm()});
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts[0].what, "elements turned; at the end");
  EXPECT_EQ(doubts[0].cure, "press less deep");
}

TEST(RunDoubts, SeeMissedImpactsAndTheLinearRangeAndTheSecondTool) {
  SessionResult result;
  result.tools[0].missed_impacts = 4;
  result.refresh.linearization_error = {0.3, 0.3, 0.3};
  ForceMetrics second = calm();
  second.crossing_jump = 0.5;
  const auto doubts = find_doubts(Scene{}, result, {}, {calm(), second});
  ASSERT_EQ(doubts.size(), 3u);
  EXPECT_NE(doubts[0].what.find("in 4 ticks"), std::string::npos);
  EXPECT_TRUE(doubts[1].what.starts_with("second tool: ")) << doubts[1].what;
  EXPECT_NE(doubts[2].what.find("linear range"), std::string::npos);
}

}  // namespace
}  // namespace kt
