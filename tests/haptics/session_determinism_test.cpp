// The same run, bit for bit: run twice, replayed, in Release and in Debug, in lockstep after threads.
#include "haptics/session/session.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <utility>

#include "haptics/link/links.hpp"
#include "haptics/session/body_film.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

SessionResult run(const Scene& scene, const SessionOptions& options = {}) { return Session(scene).run(options); }

TEST(Lockstep, TwoRunsAreEqualBitForBit) {
  for (const char* shape : {"point", "sphere"}) {
    const SessionResult a = run(small_scene(shape)), b = run(small_scene(shape));
    EXPECT_EQ(a.hash, b.hash);
    ASSERT_EQ(a.tools[0].frames.size(), 300u);
    EXPECT_GT(a.tools[0].frames.back().f_n, 0);
    EXPECT_EQ(a.refreshes, b.refreshes);
    EXPECT_EQ(a.tools[0].missed_impacts, 0);
  }
}

TEST(Lockstep, SessionRunsAgainFromTheStart) {
  Session session(small_scene());
  EXPECT_EQ(session.run().hash, session.run().hash);
}

TEST(Lockstep, ReplayOfTheScheduleIsTheRun) {
  Scene scene = small_scene();
  scene.link.latency_ms = 7;
  scene.link.loss = 0.3;
  const SessionResult first = run(scene);
  EXPECT_NE(first.hash, run(small_scene()).hash);
  Scene plain = small_scene();  // knows nothing of the link's faults
  plain.link.latency_ms = 7;    // except for the patch's size
  SessionOptions replay = replay_of(first);
  EXPECT_EQ(run(plain, replay).hash, first.hash);
}

TEST(Lockstep, LocalModelsAreRunInForFourTicks) {
  for (const int latency : {0, 3, 7}) {
    Scene scene = small_scene();
    scene.link.latency_ms = latency;
    const SessionResult first = run(scene);
    ASSERT_GT(first.refreshes.size(), 4u);
    for (std::size_t i = 1; i < first.refreshes.size(); ++i) {
      const RefreshEvent& r = first.refreshes[i];
      const int wanted = r.linearized_tick - std::max(0, 4 - latency);
      EXPECT_EQ(r.started_tick, std::max(first.refreshes[i - 1].linearized_tick + 1, wanted)) << "refresh " << i;
    }
    SessionOptions replay = replay_of(first);
    EXPECT_EQ(run(scene, replay).hash, first.hash);
    for (RefreshEvent& r : replay.replay.refreshes) r.started_tick = r.linearized_tick;
    EXPECT_EQ(run(scene, replay).hash == first.hash, latency >= 4) << "it tells";
  }
}

TEST(Lockstep, LossAndLatencyComeFromTheSeed) {
  Scene scene = small_scene();
  scene.link.loss = 0.5;
  scene.duration = 0.6;
  const auto first = run(scene).refreshes;
  EXPECT_EQ(run(scene).refreshes, first);
  scene.seed = 2;
  EXPECT_NE(run(scene).refreshes, first);
}

TEST(Lockstep, LookingDoesNotChangeTheRun) {
  SessionOptions options;
  options.check_contacts = false;
  const SessionResult plain = run(small_scene(), options);
  EXPECT_TRUE(plain.tools[0].penetration.empty());
  options.check_contacts = true;
  options.snapshot_times = {0.05, 0.1, 0.3};
  BodyFilm film(Session(small_scene()).model().mesh());
  options.film = &film;
  double progress = 0;
  options.progress = [&](double share) { progress = share; };
  const SessionResult watched = run(small_scene(), options);
  EXPECT_EQ(plain.hash, watched.hash);
  EXPECT_EQ(watched.tools[0].penetration.size(), watched.tools[0].frames.size());
  EXPECT_DOUBLE_EQ(progress, 1);
  ASSERT_EQ(watched.snapshots.size(), 3u);
  EXPECT_NEAR(watched.snapshots[1].t, 0.1, 1e-9);
  EXPECT_EQ(watched.snapshots[2].tools[0], watched.tools[0].frames.back().pose.x);
  EXPECT_TRUE(watched.snapshots[2].x.allFinite());
  EXPECT_GE(film.times().size(), static_cast<std::size_t>(small_scene().duration / film.interval()) - 1);
}

TEST(Lockstep, StopFlagEndsTheRunAndKeepsWhatIsThere) {
  std::atomic<bool> stop{false};
  SessionOptions options;
  options.stop = &stop;
  options.progress = [&](double share) { stop = share >= 0.5; };
  const SessionResult result = run(small_scene(), options);
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.tools[0].frames.size(), 150u);
  EXPECT_EQ(result.step_us.size(), 150u);
  EXPECT_EQ(result.tools[0].penetration.size(), 150u);
}

/// 40 ms a refresh where one is wanted every 33: each is begun when the one before it is done, and arrives 40 ms later.
TEST(Lockstep, ChargesARefreshWithWhatItTakes) {
  Scene scene = small_scene();
  scene.link.charge_refreshes = "given";
  scene.link.refresh_ms = 39.2;
  const SessionResult first = run(scene);
  const std::vector<RefreshEvent> wanted{{0, 0},     {33, 73},   {73, 113},  {113, 153},
                                         {153, 193}, {193, 233}, {233, 273}, {273, -1}};
  EXPECT_EQ(first.refreshes, wanted);
  EXPECT_EQ(run(scene).hash, first.hash);
  EXPECT_NE(run(small_scene()).hash, first.hash);
  SessionOptions replay = replay_of(first);
  EXPECT_EQ(run(scene, replay).hash, first.hash);
  scene.link.refresh_ms = 10;  // in time: the interval stays
  const SessionResult quick = run(scene);
  ASSERT_GT(quick.refreshes.size(), 3u);
  EXPECT_EQ(quick.refreshes[1].adopted_tick, quick.refreshes[1].linearized_tick + 10);
  EXPECT_LE(quick.refreshes[2].linearized_tick - quick.refreshes[1].linearized_tick, 33);
}

TEST(Lockstep, ChargedByTheSizesIsTheSameEverywhereAndByTheClockReplays) {
  Scene scene = small_scene();
  scene.link.charge_refreshes = "predicted";
  const SessionResult predicted = run(scene);
  EXPECT_EQ(run(scene).hash, predicted.hash);
  EXPECT_GT(predicted.refreshes[1].adopted_tick, predicted.refreshes[1].linearized_tick + 3);
  scene.link.charge_refreshes = "measured";
  const SessionResult measured = run(scene);
  SessionOptions replay = replay_of(measured);
  EXPECT_EQ(run(scene, replay).hash, measured.hash);
}

/// No refresh fits: "auto" goes down to the quickest, by the clock; the replay does so in the same refreshes.
TEST(Thread, ReplayStepsDownWhereTheRunDid) {
  Scene scene = small_scene();
  scene.duration = 0.6;
  scene.local.reducer = "auto";
  scene.local.tolerance = 1e-3;
  scene.link.type = "thread";
  scene.local.refresh_budget_ms = 1e3;  // at first any fits
  Session session(scene);
  const SessionResult calm = session.run();
  scene.local.refresh_budget_ms = 0.8 * calm.refresh.cpu_ms.back();
  const SessionResult live = run(scene);
  for (const ReducerChange& c : live.reducer_changes)
    std::printf("tick %d: %s -> %s: %s\n", c.tick, c.from.c_str(), c.to.c_str(), c.why.c_str());
  SessionOptions replay = replay_of(live);
  const SessionResult again = run(scene, replay);
  EXPECT_EQ(again.hash, live.hash);
  EXPECT_EQ(again.reducer_changes.size(), live.reducer_changes.size());
}

TEST(Thread, LockstepReplayOfAThreadedRunIsTheRun) {
  Scene scene = small_scene();
  scene.link.type = "thread";
  const SessionResult live = run(scene);
  ASSERT_EQ(live.tools[0].frames.size(), 300u);
  EXPECT_EQ(live.lateness_us.size(), 300u);
  EXPECT_GT(live.refreshes.size(), 1u);
  for (const LocalFrame& f : live.tools[0].frames) ASSERT_TRUE(f.force.allFinite());
  SessionOptions replay = replay_of(live);
  EXPECT_EQ(run(scene, replay).hash, live.hash);
}

/// Holds the body's thread up once, until there is no room for reports any more.
class HoldsUp final : public SessionWatcher {
 public:
  void begun(Touch& touch) override { touch_ = &touch; }
  void refreshed(const RefreshRecord& record) override {
    if (record.t < 0.1 || std::exchange(has_held_up_, true)) return;
    for (int i = 0; i < 60'000 && TouchHalves::lost_reports(*touch_) < 200; ++i)  // a busy machine ticks less often
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

 private:
  Touch* touch_ = nullptr;
  bool has_held_up_ = false;
};

TEST(Thread, LockstepReplayOfARunWhoseReportsWereLostIsTheRun) {
  Scene scene = small_scene();
  scene.link.type = "thread";
  scene.local.rate_hz = 4000;  // room for a second
  scene.duration = 6;          // a refresh after the one that is held up has to come, on a busy machine, too
  Session session(scene);
  HoldsUp watcher;
  SessionOptions options;
  options.watcher = &watcher;
  const SessionResult threaded = session.run(options);
  std::size_t lost = 0;
  for (const RefreshEvent& event : threaded.refreshes) lost += event.lost.size();
  ASSERT_GE(lost, 200u);
  EXPECT_EQ(session.run(replay_of(threaded)).hash, threaded.hash);
}

/// Replayed, every sweep is that of the haptic loop: a model that was brought near along others would differ.
TEST(Thread, LockstepReplayOfATurningToolIsTheRun) {
  Scene scene = small_scene("capsule");
  scene.tool.radius = 0.003;
  scene.tool.length = 0.012;
  scene.tool.turn = {1.4, 0, 0};
  scene.tool.spin = {0, 0, 12};
  scene.link.type = "thread";
  const SessionResult live = run(scene);
  EXPECT_GT(live.refreshes.size(), 1u);
  SessionOptions replay = replay_of(live);
  EXPECT_EQ(run(scene, replay).hash, live.hash);
}

/// A hand that presses beyond what its device can give, with passivity control.
TEST(Lockstep, ReplayWritesTheForcesOfTheDevice) {
  Scene scene = small_scene();
  scene.duration = 0.08;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/pad.off";
  scene.object.layers = SceneLayers{.count = 1, .thickness = 0.001};
  scene.object.model.young = 1e6;
  scene.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = {}, .device = {}};
  scene.tool.path.hand =
      SceneHand{.stiffness = 3000, .damping = 5, .target = {{0, {0.025, 0.025, 0.025}}, {0.05, {0.025, 0.025, 0.005}}}};
  scene.local.passivity_damping = 20;
  const SessionResult first = run(scene);
  ASSERT_GT(first.tools[0].limited_forces, 0);
  ASSERT_GT(first.tools[0].passivity->damped_ticks, 0);
  double most = 0, most_wanted = 0;
  for (std::size_t i = 0; i < first.tools[0].frames.size(); ++i) {
    most = std::max(most, first.tools[0].frames[i].force.norm());
    most_wanted = std::max(most_wanted, first.tools[0].model_force[i].norm());
  }
  EXPECT_LE(most, 7.9);
  EXPECT_GT(most_wanted, 8);
  SessionOptions replay = replay_of(first);
  auto& path = replay.tool_paths.emplace_back().points;
  path.push_back({0, first.tools[0].start.x});
  for (const LocalFrame& f : first.tools[0].frames) path.push_back({f.t, f.pose.x});
  const SessionResult again = run(scene, replay);
  EXPECT_EQ(again.hash, first.hash);
  EXPECT_EQ(again.tools[0].limited_forces, first.tools[0].limited_forces);
  EXPECT_EQ(again.tools[0].passivity->damped_ticks, first.tools[0].passivity->damped_ticks);
}

/// A second tool on the other side of the block.
Scene with_second_tool(Scene scene) {
  scene.second_tool = scene.tool;
  scene.second_tool->path.press_drag->at = std::array<double, 2>{0.052, 0.021};
  return scene;
}

TEST(Lockstep, TwoToolsRunAndReplayBitForBit) {
  Scene scene = with_second_tool(small_scene());
  scene.link.latency_ms = 7;
  const SessionResult first = run(scene);
  ASSERT_EQ(first.tools[1].frames.size(), 300u);
  EXPECT_GT(first.tools[1].frames.back().f_n, 0);
  EXPECT_EQ(run(scene).hash, first.hash);
  SessionOptions replay = replay_of(first);
  EXPECT_EQ(run(scene, replay).hash, first.hash);
}

TEST(Thread, LockstepReplayOfTwoToolsIsTheRun) {
  Scene scene = with_second_tool(small_scene());
  scene.link.type = "thread";
  const SessionResult live = run(scene);
  EXPECT_GT(live.refreshes.size(), 1u);
  SessionOptions replay = replay_of(live);
  EXPECT_EQ(run(scene, replay).hash, live.hash);
}

/// Explicit on both sides and with given springs: no factorization whose order of operations a library could change.
Scene golden_scene(const std::string& shape, const std::string& law) {
  Scene scene = small_scene(shape);
  scene.object.model.stiffness = 2;
  scene.object.model.calibrate = false;
  scene.object.model.damper = 1e-3;
  scene.contact.law = law;
  scene.global.integrator = "symplectic_euler";
  scene.local.integrator = "symplectic_euler";
  scene.local.reducer = "wall";
  scene.local.blend_ms = 0;
  scene.contact.metric = law == "coulomb" ? "mass" : "identity";
  return scene;
}

std::uint64_t golden_hash(const std::string& shape, const std::string& law) {
  const SessionResult r = run(golden_scene(shape, law));
  EXPECT_GT(r.tools[0].frames.back().f_n, 0) << "nothing was touched";
  return r.hash;
}

// A change here means that recorded sessions no longer replay: say so in the changelog. The values are those of x86-64.
TEST(GoldenHash, IsThatOfTheRecordedDays) {
  EXPECT_EQ(golden_hash("point", "coulomb"), 12279373317380929047u);
  EXPECT_EQ(golden_hash("sphere", "coulomb"), 6340479381792900588u);
  EXPECT_EQ(golden_hash("point", "paper_stick_slip"), 12789830645403770030u);
  EXPECT_EQ(run(with_second_tool(golden_scene("sphere", "coulomb"))).hash, 8522097576258438619u);
}

}  // namespace
}  // namespace kt
