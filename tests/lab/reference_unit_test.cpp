// What surrounds the reference: its path, its file, its key, and how forces are compared with it.
#include "lab/study/reference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;

TEST(ResampleForces, AveragesOneTickAroundItsEnd) {
  std::vector<Vec3> ramp;  // the force at the end of step i is i + 1
  for (int i = 0; i < 12; ++i) ramp.push_back(Vec3::Constant(i + 1));
  const auto even = resample_forces(ramp, 4), odd = resample_forces(ramp, 3), all = resample_forces(ramp, 1);
  ASSERT_EQ(even.size(), 3u);
  ASSERT_EQ(odd.size(), 4u);
  EXPECT_NEAR(even[0].x(), 4, kRoundoff);  // no delay on a ramp
  EXPECT_NEAR(even[1].x(), 8, kRoundoff);
  EXPECT_NEAR(even[2].x(), (0.5 * 10 + 11 + 12) / 2.5, kRoundoff);  // nothing comes after the end
  EXPECT_NEAR(odd[0].x(), 3, kRoundoff);
  EXPECT_NEAR(odd[3].x(), 11.5, kRoundoff);
  EXPECT_EQ(all, ramp);
  std::vector<Vec3> impact(12, Vec3::Zero());
  impact[5].z() = 4;  // in the middle between two ticks: to each its half
  EXPECT_NEAR(resample_forces(impact, 4)[0].z(), 0.5, kRoundoff);
  EXPECT_NEAR(resample_forces(impact, 4)[1].z(), 0.5, kRoundoff);
}

TEST(CompareForces, IsWhatMethodSectionEightSays) {
  Reference reference;
  std::vector<Vec3> forces;
  for (int i = 0; i < 100; ++i) {
    const bool weak = i < 20;  // too weak to be judged by its percentage
    reference.force.push_back(weak ? Vec3(0, 0, 0.01) : Vec3(0, 3, 4));
    forces.push_back(reference.force.back() + (i < 20   ? Vec3(0, 0, 0.05)
                                               : i < 40 ? Vec3(0.51, 0, 0)
                                                        : Vec3(0.49, 0, 0)));
  }
  const ForceError error = compare_forces(forces, reference);
  const double off = 20 * 0.05 * 0.05 + 20 * 0.51 * 0.51 + 60 * 0.49 * 0.49, size = 20 * 1e-4 + 80 * 25;
  EXPECT_NEAR(error.force_error, std::sqrt(off / size), kRoundoff);
  EXPECT_NEAR(error.jnd_fraction, 20.0 / 80, kRoundoff);
  EXPECT_NEAR(error.floor, 0.05 * std::sqrt(size / 100), kRoundoff);
  reference.force.assign(100, Vec3::Zero());
  EXPECT_EQ(compare_forces(forces, reference).force_error, 0);
}

/// A force that rises evenly and then stands still: what pressing and then dragging does.
double at_kink(double t) { return std::min(t, 0.01); }

TEST(CompareForces, AKinkOfThePathIsNoError) {
  constexpr double kTick = 1e-3;
  for (const int n : {1, 2, 10}) {
    Reference reference;
    reference.rate_hz = n / kTick;
    reference.h = kTick;
    std::vector<Vec3> ticks, steps;
    for (int i = 1; i <= 20; ++i) ticks.push_back({0, 0, at_kink(i * kTick)});
    for (int i = 1; i <= 20 * n; ++i) steps.push_back({0, 0, at_kink(i * kTick / n)});
    reference.force = resample_forces(steps, n);
    EXPECT_LT(compare_forces(ticks, reference).force_error, kRoundoff) << n;
    // An error stays one: the whole of a constant, and of one that alternates the half that a mean over a tick shows.
    for (Vec3& f : ticks) f.x() = 1e-3;
    const double size = std::sqrt(10 * 1e-4 + 385e-6);  // of the force: 1 to 10 mN, and ten times 10 mN
    EXPECT_NEAR(compare_forces(ticks, reference).force_error, std::sqrt(20.0) * 1e-3 / size, 2e-3) << n;
  }
}

TEST(CompareForces, AFileSaysWhetherItsForcesAreMeans) {
  const std::string file = std::filesystem::temp_directory_path() / "kt_read_forces_test.csv";
  write_reference(file, {.key = 1,
                         .rate_hz = 1e4,
                         .h = 1e-3,
                         .seconds = 0,
                         .force = {Vec3::Ones(), Vec3::Ones()},
                         .second_force = {},
                         .warnings = {"w"}});
  EXPECT_EQ(steps_per_tick(read_forces(file)), 10);
  std::ofstream(file) << "t,force_x,force_y,force_z\n0.001,1,2,3\n0.002,1,2,3\n";
  EXPECT_EQ(steps_per_tick(read_forces(file)), 1) << "of a trace they are those at the ends of ticks";
  std::filesystem::remove(file);
}

Scene fem_scene() {
  Scene scene = small_scene();
  scene.duration = 0.2;
  scene.object.model.type = "fem";
  scene.local.reducer = "condensed";
  return scene;
}

TEST(Reference, IsNearAGoodMethodAlongItsPath) {
  Session session(fem_scene());
  const SessionResult run = session.run();
  const Reference reference = run_reference(session, tool_paths(run), {.rate_hz = 2000});
  ASSERT_EQ(reference.force.size(), run.tools[0].frames.size());
  const ForceError error = compare_forces(tick_forces(run.tools[0].frames), reference);
  EXPECT_GT(error.force_error, 0);
  EXPECT_LT(error.force_error, 0.03);  // a tick off in time is 2 % in the press
  EXPECT_EQ(reference.rate_hz, 2000);
  EXPECT_TRUE(reference.warnings.empty());
}

TEST(Reference, GoesWhereTheHandWent) {
  Scene scene = fem_scene();
  scene.tool.path = {};
  scene.tool.path.press_drag.reset();
  scene.tool.path.hand = SceneHand{.target = {{0, {0.03, 0.026, 0.0255}}, {0.1, {0.03, 0.026, 0.02}}}};
  Session session(scene);
  const SessionResult run = session.run();
  ASSERT_GT(run.tools[0].frames.back().f_n, 0);
  const Reference reference = run_reference(session, tool_paths(run), {.rate_hz = 2000});
  EXPECT_LT(compare_forces(tick_forces(run.tools[0].frames), reference).force_error, 0.05);
}

TEST(Reference, WorksWithEveryLawAndTool) {
  for (const char* shape : {"point", "sphere"})
    for (const char* law : {"coulomb", "paper_slide", "paper_stick", "paper_stick_slip"}) {
      Scene scene = small_scene(shape);
      scene.duration = 0.04;
      scene.tool.path.press_drag->press_time = 0.03;
      scene.contact.law = law;
      if (law != std::string("coulomb")) scene.contact.metric = "identity";
      Session session(scene);
      const SessionResult run = session.run();
      const Reference reference = run_reference(session, tool_paths(run), {.rate_hz = 2000});
      ASSERT_EQ(reference.force.size(), run.tools[0].frames.size());
      EXPECT_GT(reference.force.back().z(), 0) << shape << ' ' << law;
    }
}

TEST(Reference, KeyIsOfBodyLawAndPathAndNotOfTheMethod) {
  const Session session(fem_scene());
  std::vector<PosePath> path{PosePath(10, Pose{{0.03, 0.026, 0.02}})};
  const std::uint64_t key = reference_key(session, path);
  const auto other = [&](auto change) {
    Scene scene = fem_scene();
    change(scene);
    return reference_key(Session(scene), path);
  };
  EXPECT_EQ(other([](Scene& s) { s.local.reducer = "wall"; }), key);
  EXPECT_EQ(other([](Scene& s) { s.global.rate_hz = 10; }), key);
  EXPECT_EQ(other([](Scene& s) { s.link.latency_ms = 10; }), key);
  EXPECT_NE(other([](Scene& s) { s.object.model.young *= 1.01; }), key);
  EXPECT_NE(other([](Scene& s) { s.object.model.density *= 1.01; }), key);
  EXPECT_NE(other([](Scene& s) { s.object.model.damping.stiffness *= 1.01; }), key);
  EXPECT_NE(other([](Scene& s) { s.object.size = 0.1; }), key);
  EXPECT_NE(other([](Scene& s) { s.contact.mu_static = 0.6; }), key);
  EXPECT_NE(other([](Scene& s) { s.tool.radius = 0.005; }), key);
  path[0].back().x.x() += 1e-9;
  EXPECT_NE(reference_key(session, path), key);
}

TEST(Reference, FilesReadBackAndBelongToOneRun) {
  const std::string file = std::filesystem::temp_directory_path() / "kt_reference_test.csv";
  const Reference wrote{.key = 0xabcdef0123456789,
                        .rate_hz = 1e4,
                        .h = 1e-3,
                        .seconds = 2.5,
                        .force = {{1.0 / 3, -2, 1e-300}, {0, 0.1, 7}},
                        .second_force = {},
                        .warnings = {"one", "two, or three"}};
  write_reference(file, wrote);
  const Reference read = read_reference(file, wrote.key);
  EXPECT_EQ(read.force, wrote.force);
  EXPECT_EQ(read.warnings, wrote.warnings);
  EXPECT_EQ(read.rate_hz, wrote.rate_hz);
  EXPECT_EQ(read.h, wrote.h);
  EXPECT_EQ(read.seconds, wrote.seconds);
  EXPECT_NE(message([&] { read_reference(file, 1); }).find("another body, contact law or tool path"),
            std::string::npos);
  EXPECT_NE(message([&] { read_reference(file + ".none", 1); }).find("cannot read"), std::string::npos);
  std::filesystem::remove(file);
  EXPECT_NE(message([&] { read_reference(KT_SOURCE_DIR "/README.md", 1); }).find("not a reference"), std::string::npos);
}

TEST(Reference, RefusesRatesBelowTheTick) {
  const Session session(small_scene());
  const std::vector<PosePath> path{PosePath(2, Pose{{0.03, 0.026, 0.05}})};
  for (double rate : {-1.0, 0.0, 999.0, 1.01e7, std::nan("")})
    EXPECT_EQ(message([&] { run_reference(session, path, {.rate_hz = rate}); }),
              text("reference rate: ", rate, " Hz, must be at least local.rate_hz, 1000, at most 1e+07"));
  EXPECT_EQ(run_reference(session, path, {.rate_hz = 1500}).rate_hz, 2000);
}

}  // namespace
}  // namespace kt
