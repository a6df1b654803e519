// What a run's ticks, devices, refreshes and forces show, each kind on a run made for it.
#include <gtest/gtest.h>

#include <limits>
#include <tuple>

#include "haptics/findings/kinds.hpp"

namespace kt {
namespace {

using Weight = Finding::Weight;
using Findings = std::vector<Finding>;

/// A tenth of a second of contact that nobody would notice anything of: 0.5 N, a new local model each 33 ms.
SessionResult calm_run() {
  SessionResult result;
  ToolRun& tool = result.tools[0];
  tool.frames.resize(100, LocalFrame());
  for (std::size_t i = 0; i < 100; ++i) {
    LocalFrame& f = tool.frames[i];
    f.t = 1e-3 * static_cast<double>(i + 1);
    f.mode = ContactMode::slide;
    f.force = Vec3(0, 0, 0.5);
    f.residual = 0.009;
    f.model_frame = static_cast<int>(i) / 33;
    tool.model_force.push_back(f.force);
  }
  tool.penetration.resize(100, 0.9e-4);
  return result;
}

ForceMetrics calm_force() { return {.mean_n = 1, .max_n = 2, .ticks_stick = 100}; }

RealTime quick() {
  RealTime out;
  out.refresh_share = 0.2;
  return out;
}

Findings in_ticks(const SessionResult& result, const Scene& scene = {}) {
  Findings out;
  find_in_ticks(scene, result, quick(), out);
  return out;
}

Findings withheld(const SessionResult& result, const Scene& scene = {}) {
  Findings out;
  find_withheld_forces(scene, result, out);
  return out;
}

Findings old_models(const SessionResult& result, const Scene& scene = {}) {
  Findings out;
  find_old_models(scene, result, quick(), out);
  return out;
}

/// Each finding has its part, and there are no others.
void expect_parts(const Findings& found, const std::vector<std::string>& parts) {
  ASSERT_EQ(found.size(), parts.size()) << ::testing::PrintToString(lines(found));
  for (std::size_t i = 0; i < parts.size(); ++i)
    EXPECT_NE(found[i].line().find(parts[i]), std::string::npos) << found[i].line();
}

TEST(Findings, AreNoneOfWhatNobodyNotices) {
  expect_parts(in_ticks(calm_run()), {});
  expect_parts(withheld(calm_run()), {});
  expect_parts(old_models(calm_run()), {});
  expect_parts(find_in_force(calm_force(), Scene{}, quick()), {});
}

TEST(Findings, TellHowManyTicksWereNotSolved) {
  SessionResult result = calm_run();
  result.tools[0].frames[3].residual = 0.011;
  result.tools[0].frames[70].residual = 1;
  expect_parts(in_ticks(result), {"not found to within 1 %: 2 of 100 ticks"});
}

TEST(Findings, TellHowDeepAToolWasInsideOnlyWhereItIsKeptOutside) {
  SessionResult result = calm_run();
  result.tools[0].penetration[5] = 2e-3;
  EXPECT_EQ(in_ticks(result)[0].where, "tool");
  expect_parts(in_ticks(result), {"up to 2 mm inside the body, in 1 of 100 ticks"});
  Scene paper;
  paper.contact.law = "paper_stick";
  expect_parts(in_ticks(result, paper), {});
}

TEST(Findings, OfLostContactAreFailures) {
  SessionResult result = calm_run();
  EXPECT_FALSE(contact_was_lost(Scene{}, result));
  result.tools[0].missed_impacts = 3;
  result.tools[0].lost.free_ticks_inside = 1;
  result.tools[0].lost.pass_throughs = 2;
  result.tools[0].lost.went_through = {{50, 0.4}, {70, 0.1}};
  expect_parts(
      in_ticks(result),
      {"contact was lost: the tool was inside the body without contact in 1 of 100 ticks",
       "went into the body or through it unstopped in 2 ticks, first in tick 50 (t = 0.051 s), 0.4 m in that one"});
  EXPECT_TRUE(contact_was_lost(Scene{}, result));
  EXPECT_TRUE(has_failed(in_ticks(result)));
  Scene paper;
  paper.contact.law = "paper_stick";
  EXPECT_FALSE(contact_was_lost(paper, result));
  expect_parts(in_ticks(result, paper), {});
  result = calm_run();
  result.tools[0].lost.unchecked_ticks = 7;
  expect_parts(in_ticks(result), {"contacts were not checked in 7 of 100 ticks"});
}

TEST(Findings, TellEachFlagOnceWithItsTool) {
  SessionResult result = calm_run();
  result.tools[0].frames[1].flags = result.tools[0].frames[2].flags = kLeftPatch;
  result.tools[0].frames[2].flags |= kNotFinite | kBadPose | kLateTick;
  result.tools.resize(2);
  result.tools[1].frames.resize(50, LocalFrame());
  result.tools[1].frames[0].flags = kNotFinite;
  expect_parts(
      in_ticks(result),
      {"edge of the local patch: 2 of 100 ticks, first at t = 0.002 s; set global.rate_hz to 60",
       "left the finite numbers", "second tool: the local model left",
       "pose was not usable, and it stayed where it was: 1 of 100", "more time had passed than is caught up with"});
}

/// A part that bends away yields little more with refined cells than without.
TEST(Findings, OfTicksBesideRefinedCellsWeighWhatTheseAddToTheYield) {
  SessionResult result = calm_run();
  result.tools[0].frames[9].flags = kUnrefined;
  for (const auto& [share, factor, weight] :
       {std::tuple(0.05, "(by up to 5.26 %, as far", Weight::note), {0.5, "(by up to 100 %, as far", Weight::doubt}}) {
    result.refresh.refined_share = {share, std::numeric_limits<double>::quiet_NaN(), share};
    const Findings found = in_ticks(result);
    expect_parts(found, {factor});
    EXPECT_EQ(found[0].weight, weight);
  }
}

TEST(Findings, OfTooManyPlacesAreFailuresWhereTheForcesWereNotFound) {
  SessionResult result = calm_run();
  result.tools[0].frames[9].flags = kContactsExhausted;
  EXPECT_FALSE(has_failed(in_ticks(result)));
  result.tools[0].frames[9].residual = 0.5;
  EXPECT_TRUE(has_failed(in_ticks(result)));
}

/// A device that somebody holds, with what its chain counted.
SessionResult held_run(int gated) {
  SessionResult result = calm_run();
  ToolRun& tool = result.tools[0];
  tool.device.emplace();
  tool.device->name = "haply";
  tool.device->gate = GateReason::put_down;
  tool.device->safety.ticks = 100;
  tool.device->safety.gated = gated;
  tool.device->safety.by_reason[static_cast<std::size_t>(GateReason::stale_pose)] = gated / 2;
  tool.device->safety.by_reason[static_cast<std::size_t>(GateReason::on_the_way)] = gated - gated / 2;
  for (int i = 0; i < gated; ++i) {
    tool.frames[static_cast<std::size_t>(i)].flags = kGated;
    tool.frames[static_cast<std::size_t>(i)].force.setZero();
  }
  return result;
}

TEST(Findings, OfAGateThatNeverOpensNameTheReasonAndFail) {
  const Findings found = withheld(held_run(100));
  expect_parts(found,
               {"gate never opened fully, 100 of 100 in contact: mostly because the device's pose is older than 5 ms",
                "the hand was given 0 N on average in contact, where the local model has 0.5 N"});
  EXPECT_TRUE(has_failed(found));
  EXPECT_NE(found[0].line().find("kilotouch device test haply"), std::string::npos) << found[0].line();
}

TEST(Findings, OfAGateThatIsShutForAWhileDoNotFail) {
  const Findings found = withheld(held_run(30));
  expect_parts(found, {"shut or not fully open in 30 of 100 ticks, 30 of 100 in contact",
                       "the hand was given 0.35 N on average in contact, where the local model has 0.5 N"});
  EXPECT_FALSE(has_failed(found));
  EXPECT_FALSE(is_trustworthy(found));
  expect_parts(withheld(held_run(0)), {});
}

TEST(Findings, OfForcesThatWereHeldBackHaveTheirCounts) {
  SessionResult result = held_run(0);
  result.tools[0].limited_forces = 4;
  for (std::size_t i = 0; i < 20; ++i) result.tools[0].frames[i].flags = kSlewed;
  for (std::size_t i = 90; i < 95; ++i) result.tools[0].frames[i].flags = kStalePose;
  expect_parts(withheld(result), {"cut to the device's limit in 4 ticks",
                                  "held back from changing faster than the device "
                                  "is allowed in 20 of 100 ticks in contact",
                                  "pose was too old, or the device not there, in 5 of 100 ticks in contact"});
}

/// As where no datagram gets through: by the time that one model is in use, whatever flag the ticks have.
TEST(Findings, OfOneModelForMostOfTheContactAreAFailureThatBlamesNoMesh) {
  SessionResult result = calm_run();
  ToolRun& tool = result.tools[0];
  tool.frames = {};
  tool.frames.resize(2000, LocalFrame());
  for (std::size_t i = 0; i < 2000; ++i) {
    tool.frames[i].t = 1e-3 * static_cast<double>(i + 1);
    tool.frames[i].mode = ContactMode::stick;
    tool.frames[i].model_frame = 0;
  }
  Scene scene;
  scene.link.type = "network";
  const Findings found = old_models(result, scene);
  expect_parts(found, {"no local model came after the first: in 1750 of 2000 ticks in contact"});
  EXPECT_TRUE(has_failed(found));
  for (std::size_t i = 0; i < 2000; ++i) tool.frames[i].model_frame = static_cast<int>(i) / 300;  // 50 of 300 ms late
  expect_parts(old_models(result, scene), {"local models came late: in "});
  EXPECT_FALSE(has_failed(old_models(result, scene)));
  for (std::size_t i = 0; i < 2000; ++i) tool.frames[i].model_frame = static_cast<int>(i) / 33;
  expect_parts(old_models(result, scene), {});
  for (std::size_t i = 0; i < 1200; ++i) tool.frames[i].flags = kStaleModel;
  EXPECT_TRUE(has_failed(old_models(result, scene)));
}

void expect_one(const Findings& found, const std::string& what, const std::string& cure) {
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].what.find(what), std::string::npos) << found[0].what;
  EXPECT_NE(alternatives(found[0].cures).find(cure), std::string::npos) << alternatives(found[0].cures);
}

TEST(Findings, NameALocalModelThatIsWrongAtTheRatesOfTheRun) {
  const auto in_forces = [](double error, const std::string& reducer) {
    SessionResult result = calm_run();
    result.expected_force_error = error;
    result.reducer = reducer;
    Scene scene;
    scene.local.reducer = reducer;
    Findings out;
    find_in_forces(scene, result, {{calm_force()}, {}, quick()}, out);
    return out;
  };
  expect_one(in_forces(0.19, "wall"), "local model 19 %", "local.reducer to auto");
  EXPECT_EQ(in_forces(0.19, "krylov")[0].cures.size(), 1u);
  expect_parts(in_forces(0.14, "wall"), {});
  expect_parts(in_forces(std::numeric_limits<double>::quiet_NaN(), "wall"), {});
}

TEST(Findings, NameJumpsAtEdgesWithTheirCure) {
  ForceMetrics f = calm_force();
  f.crossing_jump = 0.6;
  Scene flat;
  flat.object.mesh = "organ.off";
  expect_one(find_in_force(f, flat, quick()), "jumps by up to 60 % of its mean in one tick at an edge",
             "contact.surface to loop");
  Scene smooth = flat;
  smooth.contact.surface = "loop";
  const Finding jump = find_in_force(f, smooth, quick())[0];
  EXPECT_EQ(jump.value, 0.6);
  EXPECT_EQ(jump.limit, kNoticeableForce);
  expect_one(find_in_force(f, smooth, quick()), "60 %", "object.tetrahedralize.max_edge");
  smooth.object.mesh = "block.msh";  // it has its tetrahedra: no setting of ours refines them
  const Findings found = find_in_force(f, smooth, quick());
  expect_one(found, "60 %", "another object.mesh");
  EXPECT_EQ(found[0].line().find("tetrahedralize"), std::string::npos) << found[0].line();
}

TEST(Findings, NameJumpsAtRefreshesBuzzAndLostContacts) {
  ForceMetrics f = calm_force();
  f.refresh_jump = 0.3;
  expect_one(find_in_force(f, Scene{}, quick()), "30 %", "global.rate_hz to 60");
  Scene sharp;
  sharp.local.blend_ms = 0;
  expect_one(find_in_force(f, sharp, quick()), "30 %", "local.blend_ms to 12");
  f = calm_force();
  f.buzz = 0.2;
  expect_one(find_in_force(f, Scene{}, quick()), "above 100 Hz by 20 %", "damping");
  f = calm_force();
  f.lost_contacts = 3;
  expect_one(find_in_force(f, Scene{}, quick()), "ended 3 times", "global.rate_hz");
  Scene paper;
  paper.contact.law = "paper_stick";
  expect_one(find_in_force(f, paper, quick()), "ended 3 times", "contact.law to coulomb");
}

/// Faster refreshes are no cure where there is no time for them: the next one would be slower ones.
TEST(Findings, AskForFasterRefreshesOnlyWhereTheyFit) {
  ForceMetrics f = calm_force();
  f.refresh_jump = 0.3;
  RealTime busy = quick();
  busy.refresh_share = 0.6;
  Scene threads;
  threads.link.type = "thread";
  EXPECT_NE(find_in_force(f, threads, quick())[0].line().find("global.rate_hz to 60"), std::string::npos);
  EXPECT_EQ(find_in_force(f, threads, busy)[0].line().find("global.rate_hz"), std::string::npos);
  EXPECT_NE(find_in_force(f, Scene{}, busy)[0].line().find("a refresh then takes 120 % of its time"),
            std::string::npos);  // in lockstep nobody waits for it: told with its price
}

TEST(Findings, SayThatTheToolNeverTouched) {
  ForceMetrics f;
  f.ticks_free = 100;
  expect_one(find_in_force(f, Scene{}, quick()), "never touched", "tool.path");
}

TEST(Findings, SeeMissedImpactsTheLinearRangeAndTheSecondTool) {
  SessionResult result;
  result.tools[0].missed_impacts = 4;
  result.refresh.linearization_error = {0.3, 0.3, 0.3};
  ForceMetrics second = calm_force();
  second.crossing_jump = 0.5;
  Scene paper;
  paper.contact.law = "paper_stick";
  Findings found;
  find_in_forces(paper, result, {{calm_force(), second}, {}, quick()}, found);
  expect_parts(found, {"in 4 ticks", "second tool: ", "linear range"});
}

TEST(Findings, HaveTheBestCureFirstInOneLine) {
  const Finding found{"a value of 3 (limit 2)", {set_to("a.b", "1", "twice the time"), advise("press less deep")}};
  EXPECT_EQ(found.line(), "a value of 3 (limit 2); set a.b to 1 (twice the time), or press less deep");
  EXPECT_EQ(Finding{"a note"}.line(), "a note");
}

}  // namespace
}  // namespace kt
