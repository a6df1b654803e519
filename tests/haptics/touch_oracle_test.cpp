// The engine in a loop of one's own, against a session along the same path, and against sums by hand.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/body/state.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "haptics/watch/contact_watch.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/frames.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

TEST(Touch, OnesOwnLoopIsTheSession) {
  const Session session(small_scene());
  const SessionResult expected = Session(small_scene()).run();
  TouchOptions options = session.options();
  options.tools[0].max_speed = expected.tools[0].max_speed;
  Touch touch(session.body(), options);
  touch.place(expected.tools[0].start);
  std::vector<LocalFrame> frames;
  for (const LocalFrame& f : expected.tools[0].frames) frames.push_back(touch.tick(f.pose));
  EXPECT_EQ(hash_of(frames), expected.hash);
  EXPECT_GT(frames.back().f_n, 0.01);
  EXPECT_EQ(touch.status().refreshes, static_cast<int>(expected.refreshes.size()));
}

/// With `dt` of the rate itself it is the same; a loop of half the rate does two steps a call.
TEST(Touch, StepsAsMuchTimeAsHasPassed) {
  const Session session(small_scene());
  const SessionResult run = Session(small_scene()).run();
  const auto forces = [&](int every) {
    TouchOptions options = session.options();
    options.tools[0].max_speed = run.tools[0].max_speed;
    Touch touch(session.body(), options);
    touch.place(run.tools[0].start);
    std::vector<Vec3> out;
    for (std::size_t i = every - 1; i < run.tools[0].frames.size(); i += every)
      out.push_back(touch.tick(run.tools[0].frames[i].pose, every * 1e-3).force);
    EXPECT_EQ(touch.next_tick(), static_cast<int>(run.tools[0].frames.size()));
    return out;
  };
  const std::vector<Vec3> once = forces(1), twice = forces(2);
  for (std::size_t i = 0; i < once.size(); ++i) ASSERT_EQ(once[i], run.tools[0].frames[i].force);
  double most = 0;
  for (std::size_t i = 0; i < twice.size(); ++i)
    most = std::max(most, (twice[i] - run.tools[0].frames[2 * i + 1].force).norm());
  EXPECT_LT(most, 0.02 * run.tools[0].frames.back().force.norm()) << "the tool goes straight between two calls";

  Touch touch(session.body(), session.options());
  touch.place(run.tools[0].start);
  EXPECT_EQ(touch.tick(run.tools[0].start, 0.4e-3).flags & kLateTick, 0u);
  EXPECT_EQ(touch.next_tick(), 0) << "less than half a tick";
  touch.tick(run.tools[0].start, 0.2e-3);
  EXPECT_EQ(touch.next_tick(), 1);
  EXPECT_NE(touch.tick(run.tools[0].start, 1.0).flags & kLateTick, 0u);
  EXPECT_EQ(touch.next_tick(), 1 + Touch::kMostSteps);
  TouchOptions options = session.options();
  options.local.rate_hz = 8000;
  Touch fast(session.body(), options);
  fast.place(run.tools[0].start);
  fast.tick(run.tools[0].start, 1.0);
  EXPECT_EQ(fast.next_tick(), 160) << "20 ms: what a screen's picture takes";
}

Scene turning_capsule() {
  Scene scene = small_scene("capsule");
  scene.tool.radius = 0.003;
  scene.tool.length = 0.01;
  scene.tool.turn = {0.3, 0.2, 0};
  scene.tool.spin = {0, 2, 1};
  return scene;
}

/// A capsule that turns while it is dragged: by a script, and by poses from outside.
TEST(Touch, AStylusTurnsByItsPosesAsByTheScript) {
  Scene scene = turning_capsule();
  const SessionResult scripted = Session(scene).run();
  const Session session(scene);
  TouchOptions options = session.options();
  options.tools[0].max_speed = scripted.tools[0].max_speed;
  Touch touch(session.body(), options);
  touch.place(scripted.tools[0].start);
  double turned = 0, most = 0;
  for (const LocalFrame& f : scripted.tools[0].frames) {
    const Quaternion by_hand = Quaternion(Eigen::AngleAxisd(f.t * std::sqrt(5.0), Vec3(0, 2, 1) / std::sqrt(5.0))) *
                               Quaternion(Eigen::AngleAxisd(std::sqrt(0.13), Vec3(0.3, 0.2, 0) / std::sqrt(0.13)));
    turned = std::max(turned, f.pose.r.angularDistance(by_hand));
    const LocalFrame& mine = touch.tick(f.pose);
    ASSERT_EQ(mine.force, f.force) << f.t;
    ASSERT_EQ(mine.torque, f.torque) << f.t;
    most = std::max(most, f.torque.norm());
    // The contacts' own forces about the reference point.
    Vec3 torque = Vec3::Zero(), force = Vec3::Zero();
    for (const TickContact& s : TouchHalves::last_samples(touch)) {
      force -= s.impulse / touch.h();
      torque += (s.point - mine.pose.x).cross(Vec3(-s.impulse / touch.h()));
    }
    ASSERT_LT((torque - mine.torque).norm(), 1e-12 + 1e-9 * force.norm());
  }
  EXPECT_GT(most, 1e-5);  // [N m]
  EXPECT_LT(turned, 1e-7);
}

/// The same as a recorded path: written, read and played, 17 digits keep every bit.
TEST(Touch, ARecordedTurnIsTheScriptedOne) {
  Scene scene = turning_capsule();
  const SessionResult scripted = Session(scene).run();
  SessionOptions played = replay_of(scripted);
  ToolPath& path = played.tool_paths.emplace_back();
  const auto add = [&](double t, const Pose& pose) {
    path.points.push_back({t, pose.x});
    path.poses.push_back({t, pose});
  };
  add(0, scripted.tools[0].start);
  for (const LocalFrame& f : scripted.tools[0].frames) add(f.t, f.pose);
  scene.tool.turn = scene.tool.spin = Vec3::Zero();
  const SessionResult again = Session(scene).run(played);
  EXPECT_EQ(again.hash, scripted.hash);
  EXPECT_EQ(again.tools[0].frames.back().torque, scripted.tools[0].frames.back().torque);
}

TEST(Touch, APoseThatIsNoneLeavesTheToolWhereItWas) {
  const Session session(small_scene());
  Touch touch(session.body(), session.options());
  const Vec3 over(0.03, 0.026, 0.0245);
  for (int i = 0; i < 50; ++i) touch.tick(Pose{over});
  for (const Pose& bad : {Pose{{NAN, 0, 0}}, Pose{{0, INFINITY, 0}}, Pose{over, Quaternion(0, 0, 0, 0)},
                          Pose{over, Quaternion(NAN, 0, 0, 1)}, Pose{{1e300, 0, 0}}}) {
    const LocalFrame& f = touch.tick(bad);
    EXPECT_NE(f.flags & kBadPose, 0u);
    EXPECT_TRUE(f.force.allFinite());
    EXPECT_EQ(f.pose.x, over);
  }
  EXPECT_EQ(touch.tick(Pose{over}).flags & kBadPose, 0u);
}

TEST(Touch, BeginsWithTheFirstPoseThatIsOne) {
  const Session session(small_scene());
  const Pose over{{0.03, 0.026, 0.0245}};
  Touch late(session.body(), session.options()), at_once(session.body(), session.options());
  TouchHalves::refresh_if_due(late);  // nobody has said where
  for (const Pose& bad : {Pose{{NAN, 0, 0}}, Pose{{1e300, 0, 0}}, Pose{over.x, Quaternion(0, 0, 0, 0)}}) {
    const LocalFrame& f = late.tick(bad);
    EXPECT_EQ(f.flags, kNoModel | kBadPose);
    EXPECT_TRUE(f.force.isZero(0));
    EXPECT_THROW(late.place(bad), InputError);
  }
  EXPECT_EQ(late.next_tick(), 0);
  double most = 0;
  for (int i = 0; i < 80; ++i) {
    const Pose pose{over.x - Vec3(0, 0, 3e-5 * i)};
    const Vec3 force = late.tick(pose).force;
    EXPECT_EQ(force, at_once.tick(pose).force) << i;
    most = std::max(most, force.norm());
  }
  EXPECT_GT(most, 1e-3);
}

/// A quaternion that is long or short turns the tool, and does not stretch it.
TEST(Touch, TakesTheTurnOfAQuaternionAndNotItsLength) {
  Scene scene = small_scene();
  scene.tool.shape = "capsule";
  const Session session(scene);
  Touch unit(session.body(), session.options()), shorter(session.body(), session.options());
  const Quaternion turn(Eigen::AngleAxisd(1.2, Vec3::UnitY()));
  Quaternion scaled = turn;
  scaled.coeffs() *= 0.85;
  double most = 0;
  for (int i = 0; i < 80; ++i) {
    const Vec3 x(0.03, 0.026, 0.0245 - 3e-5 * i);
    const Vec3 force = unit.tick(Pose{x, turn}).force;
    EXPECT_LE((shorter.tick(Pose{x, scaled}).force - force).norm(), 1e-6 * (1e-3 + force.norm())) << i;
    most = std::max(most, force.norm());
  }
  EXPECT_GT(most, 1e-3);
}

TEST(Touch, IsNotStartedBeforeItIsToldWhereTheToolsAre) {
  const Session session(small_scene());
  Touch touch(session.body(), session.options());
  EXPECT_THROW(touch.start(), InputError);
  touch.place(Pose{{0.03, 0.026, 0.0245}});
  touch.start();
  touch.stop();
}

/// What a run is repeated by, as it is told.
struct Records final : ModelObserver {
  TouchReplay replay{.reducer_changes = std::vector<ReducerChange>{}};
  void refreshed(const RefreshRecord& r) override {
    replay.refreshes.push_back(r.event);
    std::ranges::copy(r.settings, std::back_inserter(replay.changes));
    std::ranges::copy(r.reducers, std::back_inserter(*replay.reducer_changes));
  }
};

TEST(Touch, ChangesOfSettingsAreRepeatedByAReplay) {
  Scene scene = small_scene();
  scene.duration = 0.6;
  Session session(scene);
  const std::vector<ToolPath> paths = session.paths();
  const auto run = [&](const TouchReplay& replay, bool changes) {
    TouchOptions options = session.options();
    options.replay = replay;
    Records records;
    Touch touch(session.body(), options);
    TouchHalves::observe(touch, &records);
    touch.place(Pose{interpolate_path(paths[0].points, 0)});
    std::vector<LocalFrame> frames;
    for (int i = 0; i < 600; ++i) {
      if (changes && i == 200) touch.set("contact.mu", 0.1);
      if (changes && i == 300) touch.set("object.model.young", 2e4);
      if (changes && i == 400) {
        touch.set("local.reducer", "krylov");
        touch.set("global.rate_hz", 60);
        touch.set("tool.radius", 0.0045);
      }
      if (changes && i == 500) touch.set("contact.surface", "loop");
      frames.push_back(touch.tick(Pose{interpolate_path(paths[0].points, (i + 1) * 1e-3)}));
    }
    // What is settled is told while it runs, the rest at the end; each refresh once, in order.
    EXPECT_GE(static_cast<int>(records.replay.refreshes.size()), touch.status().refreshes - 2);
    touch.stop();
    EXPECT_EQ(static_cast<int>(records.replay.refreshes.size()), touch.status().refreshes);
    EXPECT_TRUE(std::ranges::is_sorted(records.replay.refreshes, {}, &RefreshEvent::linearized_tick));
    return std::pair(frames, records.replay);
  };
  const auto [plain, none] = run({}, false);
  const auto [live, record] = run({}, true);
  EXPECT_TRUE(none.changes.empty());
  ASSERT_EQ(record.changes.size(), 6u);
  EXPECT_EQ(record.changes[0].key, "contact.mu");
  EXPECT_GE(record.changes[0].tick, 200);
  EXPECT_LT(record.changes[0].tick, 240);
  EXPECT_EQ(hash_of(std::span(live).first(200)), hash_of(std::span(plain).first(200)));
  EXPECT_NE(hash_of(live), hash_of(plain));
  EXPECT_LT(live[290].f_t, 0.12 * live[290].f_n) << "mu = 0.1 holds";
  EXPECT_GT(plain[290].f_t, 0.2 * plain[290].f_n);
  EXPECT_GT(live[390].f_n, 1.5 * plain[390].f_n) << "twice as stiff";
  const auto [again, unused] = run(record, false);
  EXPECT_EQ(hash_of(again), hash_of(live));
}

// Facets are numbered otherwise on each surface: contacts go from one to the next by their places.
TEST(Touch, ContactsStayWhereTheyAreWhenTheSurfaceChanges) {
  for (const bool catch_up : {false, true})
    for (const char* refine : {"off", "auto"})
      for (const auto& [from, to] : {std::pair("loop", "flat"), {"flat", "loop"}}) {
        Scene scene = small_scene();
        scene.object.model.type = "fem";
        scene.contact.surface = from;
        scene.contact.mu_static = scene.contact.mu_kinetic = 1;
        scene.local.catch_up = catch_up;
        scene.local.refine = refine;
        Session session(scene);
        Touch touch(session.body(), session.options());
        const Vec3 above = session.paths()[0].points.front().x, deep = above - Vec3(0, 0, 0.003);
        const double most = std::string_view(refine) == "off" ? 20 : 1.5;  // one surface is twice as stiff there
        LocalFrame before, least;
        for (int i = 0; i < 500; ++i) {
          if (i == 300) touch.set("contact.surface", std::string(to));
          const LocalFrame& f = touch.tick(Pose{above + std::min(1.0, i / 200.0) * (deep - above)});
          ASSERT_TRUE(f.force.allFinite());
          if (i == 299) before = least = f;
          if (i >= 300 && f.f_n < least.f_n) least = f;
          if (i >= 300) {
            EXPECT_LT(f.f_n, most * before.f_n) << from << ' ' << refine << ' ' << i;
            EXPECT_EQ(f.flags & kLostAnchor, 0u) << from << ' ' << refine << ' ' << i;
          }
        }
        EXPECT_GT(before.f_n, 0.01);
        EXPECT_GT(least.f_n, before.f_n / most) << from << ' ' << refine << ' ' << catch_up;
      }
}

// The model of another material is made of the mesh of the one before, which has the nodes of its edges already.
TEST(Touch, AMaterialOfTenNodeCellsCanBeChangedWhileItIsTouched) {
  Scene scene = small_scene();
  scene.object.model.type = "fem";
  scene.object.model.element = "tet10";
  scene.global.rate_hz = 10;
  Session session(scene);
  const auto press = [&](double young) {
    Touch touch(session.body(), session.options());
    const auto at = [](double depth) { return Pose{{0.03, 0.026, 0.0245 - depth}}; };
    touch.place(at(0));
    LocalFrame frame;
    for (int i = 0; i < 300; ++i) {
      if (i == 100) touch.set("object.model.young", young);
      frame = touch.tick(at(1e-5 * std::min(i, 200)));
    }
    touch.stop();
    return frame.f_n;
  };
  const double young = scene.object.model.young, once = press(young);
  EXPECT_GT(once, 0);
  EXPECT_NEAR(press(2 * young) / once, 2, 0.2);
}

TEST(Touch, RefusesSettingsThatCannotBeChangedThen) {
  const Session session(small_scene());
  Touch touch(session.body(), session.options());
  EXPECT_EQ(message([&] { touch.set("contact.mu", -1); }), "contact.mu is -1, must be at least 0, at most 100");
  EXPECT_NE(message([&] { touch.set("object.mesh", "a.off"); }).find("object.mesh: cannot be changed while"),
            std::string::npos);
  EXPECT_NE(message([&] { touch.set("contact.mew", 1); }).find("did you mean contact.mu?"), std::string::npos);
  EXPECT_NE(message([&] { touch.set("local.reducer", "waal"); }).find("wall"), std::string::npos);
  EXPECT_NE(message([&] { touch.set("contact.mu", NAN); }).find("must be at least 0"), std::string::npos);
  EXPECT_EQ(touch.number("contact.mu"), 0.5);
  EXPECT_EQ(message([&] { touch.place(std::span<const Pose>()); }), "place: 0 poses for 1 tools");
}

/// The smallest model of one's own: points on springs to where they were.
class Jelly final : public DeformableModel {
 public:
  explicit Jelly(Mesh mesh) : mesh_(std::move(mesh)) {
    const int n = mesh_.num_nodes();
    mass_.resize(3 * n, 3 * n);
    mass_.setIdentity();
    mass_ *= 1e-4;
    for (int i = 0; i < n; ++i)
      if (mesh_.x[3 * i + 2] < 0.002) fixed_.push_back(i);
  }
  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }
  void force(const State& s, VectorX& out) const override { out = -20 * (s.x - mesh_.x) - 0.02 * s.v; }

 private:
  Mesh mesh_;
  SparseMatrix mass_;
  std::vector<int> fixed_;
};

TEST(Touch, TakesAModelOfOnesOwn) {
  const Body body(std::make_unique<Jelly>(Session(small_scene()).model().mesh()));
  TouchOptions options;
  options.collision.backend = "brute_force";
  options.local.reducer = "wall";
  Touch touch(body, options);
  touch.place(Pose{{0.03, 0.026, 0.03}});
  LocalFrame f;
  for (int i = 0; i <= 500; ++i) f = touch.tick(Pose{{0.03, 0.026, 0.03 - 0.008 * std::min(1.0, i / 300.0)}});
  EXPECT_GT(f.f_n, 0.01);
  EXPECT_EQ(f.flags & kBodyFailed, 0u);
  EXPECT_NE(message([&] { touch.set("object.model.young", 1e4); }).find("the caller's own"), std::string::npos);
  VectorX x;
  touch.copy_positions(x);
  EXPECT_EQ(x.size(), body.model().mesh().x.size());
}

}  // namespace
}  // namespace kt
