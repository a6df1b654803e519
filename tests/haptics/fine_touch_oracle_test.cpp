// What a tool feels of a body whose cells are refined under it, through the whole tick and refresh: the continuum's
// force, at rest with the body; no energy over zones that move; the same bits again.
#include <gtest/gtest.h>

#include <complex>
#include <cstdio>
#include <numbers>

#include "haptics/findings/run_findings.hpp"
#include "haptics/touch/touch.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/drag_ripple.hpp"
#include "tests/support/fine_block.hpp"
#include "tests/support/hand_work.hpp"

namespace kt {
namespace {

/// The continuum's: of a ball that meets the body where it has moved to, and pushes along its own normals.
double force_over_continuum(const BlockPress& p) {
  const double truth = press_axisymmetric({.young = 1e4,
                                           .poisson = 0.3,
                                           .thickness = kBlockThick,
                                           .width = kBlockWide / std::sqrt(3.14159265358979323846),
                                           .radius = kBallRadius,
                                           .depth = p.depth,
                                           .cells = 16,
                                           .follows = true})
                           .force;
  const SessionResult r = run(p);
  const auto& frames = r.tools[0].frames;
  const double last = frames.back().f_n, before = frames[frames.size() - 100].f_n;
  EXPECT_NEAR(before / last, 1, 0.01) << "the force is not at rest";
  return last / truth;
}

TEST(FineTouch, GivesTheContinuumsForceWhereverItPresses) {
  for (const double depth : {0.0005, 0.0015})
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.5, 0.0}, {0.6, 0.3}}) {
      const double factor = force_over_continuum({.depth = depth, .x = x, .y = y});
      EXPECT_GE(factor, 0.97) << depth << ' ' << x << ' ' << y;
      EXPECT_LE(factor, 1.12) << depth << ' ' << x << ' ' << y;
    }
  EXPECT_LE(force_over_continuum({.cell = 0.01, .x = 0.3}), 1.12);
  EXPECT_GE(force_over_continuum({.refine = "off"}), 1.4) << "the mesh's force, which is not that of the body";
}

struct Shear {
  double stiffness = 0;  // tangential, before it slips [N/m]
  double creep = 0;      // of the tangential force while the tool stands still, relative
  double cone = 0;       // largest |f_t| / f_n of a contact
};

/// Pressed 1.5 mm into a block 40 mm high, moved aside by `way` and held there.
Shear shear(double way, double mu, const std::string& refine) {
  constexpr double kHigh = 0.04, kCell = 0.005, kDepth = 0.0015;
  Scene scene = scene_of({.mu = mu, .duration = 1.2, .refine = refine});
  const Vec3 above(0.031, 0.032, kHigh + kBallRadius + 5e-4), pressed(0.031, 0.032, kHigh + kBallRadius - kDepth);
  scene.tool.path.press_drag.reset();
  const Vec3 aside = pressed + Vec3(way, 0, 0);
  scene.tool.path.waypoints = {{0, above}, {0.2, pressed}, {0.5, pressed}, {0.7, aside}, {1.2, aside}};
  const SessionResult r = Session(scene, kuhn_block(12, 12, 8, kCell)).run();
  const auto& frames = r.tools[0].frames;
  const auto along = [&](int tick) { return frames[static_cast<std::size_t>(tick)].force.x(); };
  Shear out{(along(495) - along(1190)) / way, std::abs(along(900) / along(1190) - 1), 0};
  for (const LocalFrame& frame : frames) out.cone = std::max(out.cone, frame.cone_ratio);
  return out;
}

// Mindlin 1949: 8 a G / (2 - nu) of a circle that sticks, here a = sqrt(R d).
TEST(FineTouch, GivesWayAsideAsMindlinsContact) {
  const double mindlin = 8 * std::sqrt(kBallRadius * 0.0015) * (1e4 / 2.6) / 1.7;
  const Shear fine = shear(3e-4, 10, "auto");
  std::printf("tangential stiffness over Mindlin's %.3f, creep %.1e\n", fine.stiffness / mindlin, fine.creep);
  EXPECT_NEAR(fine.stiffness / mindlin, 1, 0.1);
  EXPECT_LT(fine.creep, 1e-3);
  EXPECT_GT(shear(3e-4, 10, "off").stiffness / mindlin, 1.15) << "the mesh's, which is not the body's";
  const Shear slips = shear(4e-3, 0.3, "auto");
  EXPECT_NEAR(slips.cone, 0.3, 1e-6);
}

// A contact that grows from one refresh to the next: the cells made for it have the size that it will have.
TEST(FineTouch, ABallThatPressesFastStaysOutside) {
  Scene scene = scene_of({.depth = 0.005, .mu = 0.1});
  scene.global.rate_hz = 20;
  scene.tool.path.press_drag->press_time = 0.12;
  const SessionResult r = Session(scene, block_of({})).run();
  EXPECT_LT(std::ranges::max(r.tools[0].penetration), 5e-5);
  EXPECT_GT(r.tools[0].frames.back().f_n, 0.3);
}

// Refined cells have no mass: their rate takes on the tool's speed. An impulse on the coarse nodes, as a contact
// without them needs it, was felt as a knock: four times the force of the tick after it.
TEST(FineTouch, ATouchAtSpeedIsNoKnock) {
  const SessionResult r = run({.cell = 0.01, .depth = 0.004, .mu = 0.3, .press_time = 0.05});
  const auto& frames = r.tools[0].frames;
  const auto first = std::ranges::find_if(frames, [](const LocalFrame& f) { return f.f_n > 0; }) - frames.begin();
  const double most = std::ranges::max_element(frames, {}, &LocalFrame::f_n)->f_n;
  ASSERT_GT(most, 0.05);
  for (auto i = first; i < first + 2; ++i) EXPECT_LT(frames[static_cast<std::size_t>(i)].f_n, 0.05 * most) << i - first;
}

// Nodes of cells that are ever smaller would be more places to touch than a tick holds (kMaxContacts): the force of a
// tick that leaves some out is 0.8 to 0.95 of the continuum's.
TEST(FineTouch, TakesNoSmallerCellsThanATickHolds) {
  for (const auto& [depth, x] : {std::pair(0.0008, 0.5), std::pair(0.0011, 0.0)}) {
    const double factor = force_over_continuum({.depth = depth, .x = x, .fineness = 0.5, .nodes = 3000});
    EXPECT_GE(factor, 0.99) << depth;
    EXPECT_LE(factor, 1.14) << depth;
  }
}

// While a model is in use the contact of a press grows, and has more nodes than a tick holds. When some that lie apart
// were held instead, the force leapt by a quarter of its largest value, and the ball was 0.37 mm inside.
TEST(FineTouch, APressThatWidensTheContactMakesNoLeap) {
  for (const double cell : {0.005, 0.02 / 3}) {
    const SessionResult pressed = run({.cell = cell, .depth = 0.004, .duration = 0.35});
    double most = 0, step = 0, before = 0;
    for (const LocalFrame& f : pressed.tools[0].frames) {
      step = std::max(step, std::abs(f.f_n - before));
      most = std::max(most, f.f_n);
      before = f.f_n;
    }
    EXPECT_LT(step, 0.05 * most) << cell;
    EXPECT_LT(*std::ranges::max_element(pressed.tools[0].penetration), 1e-4) << cell;  // at the rim: 0.37 mm before
  }
}

// A fast press whose models come late is expected to go on: cells made for that contact are too large for the one that
// is there.
TEST(FineTouch, RefinesAnewWhereTheContactIsSmallerThanExpected) {
  const auto force = [](double latency_ms) {
    BlockPress p{.depth = 0.0012, .duration = 0.8};
    p.latency_ms = latency_ms;
    p.press_time = 0.1;
    return run(p).tools[0].frames.back().f_n;
  };
  EXPECT_NEAR(force(40) / force(100), 1, 0.005);
}

// Cells that local.refine_nodes leaves too large: the force is far off, and the run says so.
TEST(FineTouch, SaysWhereTheRefinedCellsAreTooLarge) {
  const auto cure = [](int nodes, const std::string& charge) -> std::string {
    const BlockPress p{.cell = 0.01, .depth = 0.0005, .duration = 0.45, .nodes = nodes};
    Scene scene = scene_of(p);
    scene.link.charge_refreshes = charge;
    scene.link.refresh_ms = 25;
    Session session(scene, block_of(p));
    const SessionResult r = session.run();
    for (const Finding& f : all_findings(session, r))
      if (f.where == "local.refine_nodes") return f.cures.at(0).key;
    return "none is told";
  };
  EXPECT_EQ(cure(300, "none"), "local.refine_nodes");
  EXPECT_EQ(cure(300, "given"), "global.rate_hz") << "more nodes make models later still";
  EXPECT_EQ(cure(900, "none"), "none is told");
}

// A capsule of 20 mm that lies is refined along its contact, and the places of one of 40 mm are more than a tick holds.
TEST(FineTouch, SaysWhereNoCellsAreRefined) {
  const BlockPress p{.duration = 0.4, .press_time = 0.2};
  Scene s = scene_of(p);
  const auto is_told = [&] {
    Session session(s, block_of(p));
    const SessionResult result = session.run();
    return std::ranges::any_of(lines(all_findings(session, result)), [](const std::string& line) {
      return line.starts_with("no cells could be refined under the tool in ");
    });
  };
  EXPECT_FALSE(is_told());
  s.tool.shape = "capsule";
  s.tool.radius = 0.004;
  s.tool.turn = Vec3(std::numbers::pi / 2, 0, 0);
  s.tool.length = 0.02;
  EXPECT_FALSE(is_told());
  s.tool.length = 0.04;
  EXPECT_TRUE(is_told());
}

// A capsule that lies, against a body of ten-node cells of 2.3 mm under it that is stepped as a whole: its forces by
// `fine_reference_table 9 presses`, where the ball's are 1.04 to 1.10 of the continuum's.
TEST(FineTouch, RefinesAlongACapsuleThatLies) {
  struct Case {
    double cell, depth, force;
  };
  for (const Case& c :
       {Case{0.005, 0.0015, 0.2534}, {0.005, 0.003, 0.6541}, {0.01, 0.0015, 0.2534}, {0.01, 0.003, 0.6541}}) {
    const BlockPress p{.cell = c.cell, .depth = c.depth, .duration = 0.3, .press_time = 0.15};
    Scene s = scene_of(p);
    s.tool.shape = "capsule";
    s.tool.radius = 0.004;
    s.tool.length = 0.02;
    s.tool.turn = Vec3(std::numbers::pi / 2, 0, 0);
    s.tool.path.press_drag->at = std::array{0.5 * kBlockWide + 0.0007, 0.5 * kBlockWide + 0.0011};
    const SessionResult r = Session(s, block_of(p)).run();
    const auto& frames = r.tools[0].frames;
    EXPECT_NEAR(frames.back().f_n / c.force, 0.95, 0.13) << c.cell << ", " << c.depth;
    for (std::size_t i = 151; i < frames.size(); ++i) {
      EXPECT_NEAR(frames[i].f_n, frames[i - 1].f_n, 0.03 * c.force) << c.cell << ", " << c.depth << ", tick " << i;
      EXPECT_EQ(frames[i].flags & (kUnrefined | kLeftPatch), 0u) << c.cell << ", " << c.depth << ", tick " << i;
    }
  }
}

// A tool that stays on the refined cells, and one that outruns them: the ticks say so, and the run.
TEST(FineTouch, SaysWhereAToolOutrunsTheRefinedCells) {
  const auto unrefined_ticks = [](double speed, double rate_hz) {
    Scene scene = scene_of({.speed = speed, .mu = 0.3, .duration = 0.45});
    scene.global.rate_hz = rate_hz;
    const SessionResult r = Session(scene, block_of({})).run();
    return std::ranges::count_if(r.tools[0].frames, [](const LocalFrame& f) { return (f.flags & kUnrefined) != 0; });
  };
  EXPECT_EQ(unrefined_ticks(0.03, 30), 0);
  EXPECT_GT(unrefined_ticks(0.12, 4), 10);
}

// What the global step expects of the contact is what the ticks find, at rest: else refreshes come early for nothing.
TEST(FineTouch, GlobalStepFindsTheForceOfTheTicks) {
  for (const double mu : {0.0, 0.5}) {
    const SessionResult r = run({.depth = 0.003, .mu = mu});
    ASSERT_FALSE(r.refresh.linearization_error.empty());
    EXPECT_LT(std::abs(r.refresh.linearization_error.back()), 0.02) << mu;
  }
}

// Pressed in, moved to and fro over zones that move with it, and let go: the hand gets nothing out of it.
TEST(FineTouch, GivesNoEnergyOverZonesThatMove) {
  Scene scene = scene_of({.duration = 1.4});
  const Vec3 above(0.025, 0.028, kBlockThick + kBallRadius + 5e-4),
      pressed(0.025, 0.028, kBlockThick + kBallRadius - 1.5e-3);
  const Vec3 aside = pressed + Vec3(0.012, 0.004, 0);
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = {{0, above}, {0.2, pressed}, {0.3, pressed}, {0.7, aside}, {1.1, pressed}, {1.3, above}};
  const SessionResult r = Session(scene, block_of({})).run();
  const auto& frames = r.tools[0].frames;
  for (const LocalFrame& frame : frames) ASSERT_TRUE(frame.force.allFinite());
  const auto [given, most, dragged] = hand_work({frames.begin(), frames.end()}, 0.3, 1.1);
  EXPECT_GT(most, 5e-5) << "it was pressed in";
  EXPECT_GT(given, 0);
  EXPECT_GT(dragged, 0);
  EXPECT_EQ(frames.back().mode, ContactMode::free);
  EXPECT_EQ(r.tools[0].lost.free_ticks_inside, 0);
}

// Dragged over zones that move: the cells as they are wave by 11 % here, and by 34 % at a third of the depth
// (bench/fine_touch_table drags).
TEST(FineTouch, TheForceOfADragStaysNearItsMean) {
  const SessionResult r = run({.depth = 0.0015, .x = -2, .y = 0.3, .speed = 0.02, .duration = 1.1});
  const DragRipple found = drag_ripple({r.tools[0].frames.begin(), r.tools[0].frames.end()}, 450);
  EXPECT_LT(found.peak_to_peak, 0.065) << "ripple";
  EXPECT_LT(found.largest_step, 0.03) << "a zone that moved";
}

/// Stiffness of a ball 1.5 mm deep that shakes by 20 um in some tones at a time [N/m].
std::vector<std::complex<double>> impedance(const std::string& refine, const std::vector<double>& tones) {
  constexpr int kFrom = 500, kTicks = 1000;
  Scene scene = scene_of({.refine = refine});
  scene.object.model.damping.stiffness = 0.002;
  Session session(scene, block_of({}));
  Touch touch(session.body(), session.options());
  const auto height = [&](int i) {
    double z = kBlockThick + kBallRadius + 1e-4 - 0.0016 * std::min(1.0, i / 250.0);
    if (i > kFrom)
      for (const double hz : tones) z += 2e-5 * std::sin(2 * std::numbers::pi * hz * (1e-3 * (i - kFrom) + hz));
    return z;
  };
  const auto pose = [&](int i) { return Pose{Vec3(0.5 * kBlockWide + 0.0007, 0.5 * kBlockWide + 0.0011, height(i))}; };
  touch.place(pose(0));
  std::vector<std::complex<double>> force(tones.size()), moved(tones.size());
  for (int i = 0; i <= kFrom + kTicks; ++i) {
    const double f = touch.tick(pose(i)).force.z();
    for (std::size_t k = 0; i > kFrom && k < tones.size(); ++k) {
      const auto turn = std::polar(1.0, -2 * std::numbers::pi * tones[k] * 1e-3 * (i - kFrom));
      force[k] += f * turn;
      moved[k] += height(i) * turn;
    }
  }
  std::vector<std::complex<double>> out;
  for (std::size_t k = 0; k < tones.size(); ++k) out.push_back(-force[k] / moved[k]);
  return out;
}

// Stiffness and phase of a body that is fine everywhere and is stepped as a whole, by bench/fine_reference_table 12
// vibration.
TEST(FineTouch, AnswersToVibrationAsFineCellsDo) {
  const std::vector<double> tones{2, 10, 20, 50}, stiffness{98.5, 98.3, 97.7, 111.5}, degrees{1.9, 5.2, 11.9, 46.1};
  const auto refined = impedance("follow", tones), as_they_are = impedance("off", tones);
  for (std::size_t k = 0; k < tones.size(); ++k) {
    const auto truth = std::polar(stiffness[k], degrees[k] * std::numbers::pi / 180);
    EXPECT_LT(std::abs(refined[k] / truth - 1.0), 0.1) << tones[k];
    EXPECT_GT(std::abs(as_they_are[k] / truth), 1.3) << tones[k];
  }
}

TEST(FineTouch, TicksTakeNoMemory) {
  Scene scene = scene_of({.mu = 0.4});
  scene.global.rate_hz = 1;  // no refresh among the ticks
  Session session(scene, block_of({}));
  Touch touch(session.body(), session.options());
  const auto pose = [](int tick) {
    return Pose{Vec3(0.5 * kBlockWide + 2e-6 * tick, 0.5 * kBlockWide,
                     kBlockThick + kBallRadius + 1e-4 - 5e-6 * std::min(tick, 300))};
  };
  touch.place(pose(0));
  touch.tick(pose(0));
  LocalFrame frame;
  EXPECT_EQ(allocations_during([&] {
              for (int i = 1; i <= 500; ++i) frame = touch.tick(pose(i));
            }),
            0);
  EXPECT_GT(frame.contacts, 5);
  EXPECT_GT(frame.f_n, 0.05);
}

TEST(FineTouch, IsRepeatedBitForBit) {
  const BlockPress p{.speed = 0.03, .mu = 0.4, .duration = 0.6};
  EXPECT_EQ(run(p).hash, run(p).hash);
}

// As that of cells as they are (session_determinism_test.cpp): a change here means that recorded sessions no longer
// replay.
TEST(GoldenHash, OfRefinedCellsIsThatOfTheRecordedDays) {
  const SessionResult r = run({.cell = 0.01, .speed = 0.05, .mu = 0.3, .duration = 0.45});
  ASSERT_FALSE(r.refresh.fineness.empty());
  EXPECT_EQ(r.hash, 3915704859946497277u);
}

// Where models come late, most refreshes do not wait for refined cells: they were made while the model before was in
// use. The tool stays on them, the force at rest is the same, and so are the bits.
TEST(FineTouch, CellsAreMadeARefreshAheadWhereModelsComeLate) {
  const BlockPress p{
      .depth = 0.0011, .mu = 0.4, .duration = 0.6};  // whose cells are of one size, however late they are
  Scene scene = scene_of(p);
  scene.link.charge_refreshes = "given";
  scene.link.refresh_ms = 25;
  const auto late = [&](double speed) {
    scene.tool.path.press_drag->speed = speed;
    return Session(scene, block_of({})).run();
  };
  const SessionResult rest = late(0), first = late(0.03), second = late(0.03);
  EXPECT_NEAR(rest.tools[0].frames.back().f_n / run(p).tools[0].frames.back().f_n, 1, 0.01);
  EXPECT_EQ(first.hash, second.hash);
  const auto outran = [](const LocalFrame& f) { return (f.flags & kUnrefined) != 0; };
  EXPECT_EQ(std::ranges::count_if(first.tools[0].frames, outran), 0);
  const std::vector<double>& waited = first.refresh.parts_ms[2].second;
  ASSERT_EQ(first.refresh.parts_ms[2].first, "refine");
  EXPECT_LT(std::ranges::count_if(waited, [](double ms) { return ms > 0; }), waited.size() / 2);
}

}  // namespace
}  // namespace kt
