#include "haptics/session/run_warnings.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

using Texts = std::vector<std::string>;

SessionResult calm_run() {
  SessionResult result;
  result.tools[0].frames.resize(100, LocalFrame());
  for (LocalFrame& frame : result.tools[0].frames) frame.residual = 0.009;
  result.tools[0].penetration.resize(100, 0.9e-4);
  return result;
}

/// Each warning has its part, and there are no others.
void expect_parts(const Texts& warnings, const Texts& parts) {
  ASSERT_EQ(warnings.size(), parts.size()) << ::testing::PrintToString(warnings);
  for (std::size_t i = 0; i < parts.size(); ++i)
    EXPECT_NE(warnings[i].find(parts[i]), std::string::npos) << warnings[i];
}

TEST(RunWarnings, AreNoneOfWhatNobodyNotices) { expect_parts(run_warnings(calm_run(), true), {}); }

TEST(RunWarnings, TellHowManyTicksWereNotSolved) {
  SessionResult result = calm_run();
  result.tools[0].frames[3].residual = 0.011;
  result.tools[0].frames[70].residual = 1;
  expect_parts(run_warnings(result, true), {"not found to within 1 %: 2 of 100 ticks"});
}

TEST(RunWarnings, TellHowDeepAToolWasInsideOnlyWhereItIsKeptOutside) {
  SessionResult result = calm_run();
  result.tools[0].penetration[5] = 2e-3;
  expect_parts(run_warnings(result, true), {"up to 2 mm inside the body, in 1 of 100 ticks"});
  expect_parts(run_warnings(result, false), {});
}

TEST(RunWarnings, TellWhereContactWasLost) {
  SessionResult result = calm_run();
  EXPECT_FALSE(contact_was_lost(result, true));
  for (std::size_t i = 0; i < 100; ++i) result.tools[0].frames[i].t = 1e-3 * static_cast<double>(i + 1);
  result.tools[0].missed_impacts = 3;
  result.tools[0].lost.free_ticks_inside = 1;
  result.tools[0].lost.pass_throughs = 2;
  result.tools[0].lost.went_through = {{50, 0.4}, {70, 0.1}};
  expect_parts(
      run_warnings(result, true),
      {"contact was lost: the tool was inside the body without contact in 1 of 100 ticks",
       "went into the body or through it unstopped in 2 ticks, first in tick 50 (t = 0.051 s), 0.4 m in that one"});
  EXPECT_TRUE(contact_was_lost(result, true));
  EXPECT_FALSE(contact_was_lost(result, false));
  expect_parts(run_warnings(result, false), {});
  result = calm_run();
  result.tools[0].lost.unchecked_ticks = 7;
  expect_parts(run_warnings(result, true), {"contacts were not checked in 7 of 100 ticks"});
}

TEST(RunWarnings, TellEachFlagOnceWithItsTool) {
  SessionResult result = calm_run();
  result.warnings = {"from the start"};
  result.tools[0].frames[1].flags = result.tools[0].frames[2].flags = kLeftPatch;
  result.tools[0].frames[2].flags |= kNotFinite;
  result.tools.resize(2);
  result.tools[1].frames.resize(50, LocalFrame());
  result.tools[1].frames[0].flags = kNotFinite;
  result.stopped = true;
  expect_parts(run_warnings(result, true),
               {"from the start", "edge of the local patch (raise global.rate_hz or move slower): 2 of 100 ticks",
                "(use local.integrator implicit_euler): 1 of 100 ticks", "second tool: the local model left",
                "stopped early, after 100 ticks"});
}

}  // namespace
}  // namespace kt
