// What a patch covers when its local model comes late: the way that the tool is expected to go, no more than half as
// many vertices again as of one that is there at once; and the apron stops the tool beyond.
#include "haptics/refresh/patch_site.hpp"

#include <gtest/gtest.h>

#include <random>

#include "haptics/halves/body_side.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/refresh/look_ahead.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.004;  // [m]

/// In the middle of a sheet.
ToolPlace in_the_middle(const Mesh& mesh) { return {.place = bounds(mesh).centre(), .reach = 0.008}; }

TEST(PatchSite, CoversEveryPlaceOnAShortWay) {
  const Mesh mesh = sheet(40, 30, kCell);
  const Surface surface = make_surface(mesh);
  ToolPlace tool = in_the_middle(mesh);
  for (const Vec3& way : {Vec3(0.007, 0.002, 0), Vec3(-0.004, 0.006, 0.001), Vec3(0, 0, -0.005)}) {
    tool.way = way;
    const ContactSite site = find_contact_sites(surface, mesh.x, {&tool, 1});
    ASSERT_EQ(site.way, way) << "shortened";
    const SurfacePatch patch = make_patch(surface, mesh.x, site);
    for (int i = 0; i <= 50; ++i) {
      const Vec3 on_way = site.centre + i / 50.0 * way;
      for (int v = 0; v < mesh.num_nodes(); ++v) {
        if ((node(mesh.x, v) - on_way).norm() > tool.reach) continue;
        EXPECT_TRUE(std::ranges::binary_search(patch.global_node, v)) << "node " << v << " at " << i / 50.0;
      }
    }
  }
}

TEST(PatchSite, IsAtMostHalfAsLargeAgainAndNeverSmaller) {
  const Mesh mesh = sheet(60, 60, kCell);
  const Surface surface = make_surface(mesh);
  const auto patch_of = [&](const ToolPlace& tool) {
    return make_patch(surface, mesh.x, find_contact_sites(surface, mesh.x, {&tool, 1})).global_node;
  };
  ToolPlace tool = in_the_middle(mesh);
  const std::vector<int> at_once = patch_of(tool);
  for (const double way : {0.0, 0.01, 0.05, 0.4})
    for (const double margin : {0.0, 0.005, 0.05}) {
      tool.way = {0.8 * way, 0.6 * way, 0};
      tool.margin = margin;
      const std::vector<int> late = patch_of(tool);
      EXPECT_LE(late.size(), 1.5 * static_cast<double>(at_once.size())) << way << ", " << margin;
      EXPECT_TRUE(std::ranges::includes(late, at_once)) << way << ", " << margin;
      if (way + margin >= 0.015) {
        EXPECT_GT(late.size(), 1.15 * static_cast<double>(at_once.size())) << way << ", " << margin;
      }
    }
}

TEST(ExpectedWay, IsNoLongerThanTheWayThatTheToolCame) {
  const Vec3 velocity(0.1, -0.02, 0);
  EXPECT_NEAR((expected_way(velocity, 0.2 * velocity, 0.2) - 0.2 * velocity).norm(), 0, 1e-15);
  EXPECT_NEAR((expected_way(velocity, 5 * velocity, 0.2) - 0.2 * velocity).norm(), 0, 1e-15) << "it brakes";
  EXPECT_NEAR((expected_way(velocity, 0.05 * velocity, 0.2) - 0.05 * velocity).norm(), 0, 1e-15) << "it began";
  EXPECT_EQ(expected_way(velocity, -0.05 * velocity, 0.2), Vec3::Zero()) << "it turned round";
  EXPECT_EQ(expected_way(Vec3::Zero(), velocity, 0.2), Vec3::Zero());
  EXPECT_EQ(expected_way(velocity, velocity, 0), Vec3::Zero());
}

TEST(PastPlaces, TellTheWayFromASpanBefore) {
  PastPlaces past;
  EXPECT_EQ(past.came(0, 0.1), Vec3::Zero());
  const auto x = [](double t) { return Vec3(0.3 * t, std::abs(t - 1), 0); };
  for (int i = 0; i <= 40; ++i) {
    const std::array<Pose, 2> tools{Pose{x(0.05 * i)}, Pose{2 * x(0.05 * i)}};
    past.add(0.05 * i, tools);
  }
  for (const double span : {0.0, 0.05, 0.123, 0.4, 0.9}) {
    EXPECT_NEAR((past.came(0, span) - (x(2) - x(2 - span))).norm(), 0, 1e-12) << span;
    EXPECT_NEAR((past.came(1, span) - 2 * (x(2) - x(2 - span))).norm(), 0, 1e-12) << span;
  }
  EXPECT_LE(past.came(0, 1.9).norm(), 1.01 * (x(2) - x(0.95)).norm()) << "only a second is kept";
}

/// A tool that turns about at 0.25 m/s, of which no bound is known, as of a hand.
std::vector<TimedPoint> turning_about() {
  std::vector<TimedPoint> out{{0, {0.03, 0.025, 0.026}}, {0.1, {0.03, 0.025, 0.0215}}};
  std::mt19937_64 random(3);
  const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  while (out.back().t < 0.5) {
    const Vec3 next(0.012 + 0.056 * share(), 0.012 + 0.026 * share(), 0.0215);
    out.push_back({out.back().t + (next - out.back().x).norm() / 0.25 + 1e-3, next});
  }
  return out;
}

/// How many vertices patches have.
class PatchSizes final : public SessionWatcher {
 public:
  void begun(Touch& touch) override { touch_ = &touch; }
  void ticked(std::span<const LocalFrame>, double, long long) override {
    const int vertices = TouchHalves::fast(*touch_).model().model.patch.num_vertices();
    most = std::max(most, vertices);
    sum += vertices;
    ++ticks;
  }
  double mean() const { return sum / ticks; }
  int most = 0, ticks = 0;
  double sum = 0;

 private:
  const Touch* touch_ = nullptr;
};

struct TurnedAbout {
  SessionResult run;
  PatchSizes vertices;
};

TurnedAbout turned_about(double latency_ms) {
  Scene scene = small_scene();
  scene.link.latency_ms = latency_ms;
  scene.link.loss = latency_ms > 0 ? 0.2 : 0;
  Session session(scene);
  session.follow(turning_about());
  SessionOptions options;
  options.max_speeds = {std::numeric_limits<double>::infinity()};
  PatchSizes watcher;
  options.watcher = &watcher;
  SessionResult run = session.run(options);
  return {std::move(run), watcher};
}

/// 200 ms until a model is there. Before, the patch was the whole top.
TEST(PatchUnderDelay, StaysSmallAndTheApronStopsTheTool) {
  const TurnedAbout at_once = turned_about(0), late = turned_about(200);
  EXPECT_LE(late.vertices.mean(), 1.6 * at_once.vertices.mean());
  EXPECT_LE(late.vertices.most, 1.8 * at_once.vertices.most);  // the refreshes are elsewhere on the way
  const ToolRun& tool = late.run.tools[0];
  EXPECT_EQ(tool.missed_impacts, 0);
  const auto flagged = [&](unsigned flag) {
    return std::ranges::count_if(tool.frames, [&](const LocalFrame& f) { return (f.flags & flag) != 0; });
  };
  EXPECT_GT(flagged(kLeftPatch), 0) << "nothing tempted it";
  int inside = 0, unflagged = 0;
  for (std::size_t i = 0; i < tool.frames.size(); ++i) {
    const bool is_inside = tool.penetration[i] > 1e-4;
    inside += is_inside;
    unflagged += is_inside && tool.frames[i].mode == ContactMode::free;
  }
  EXPECT_EQ(unflagged, 0) << "inside and free";
  EXPECT_EQ(inside, 0);
  std::printf("%d vertices at once, %d late; of %zu ticks %ld on the apron, %d inside, %ld pushed out\n",
              at_once.vertices.most, late.vertices.most, tool.frames.size(), static_cast<long>(flagged(kLeftPatch)),
              inside, static_cast<long>(flagged(kPushedOut)));
}

/// 60 Hz could be 240 for a body that bends away, each model of it 400 ms on its way.
TEST(PatchUnderDelay, AsksForFourModelsADelayAtMost) {
  Scene scene = small_scene();
  scene.global.rate_hz = 60;
  scene.local.tolerance = 1e-9;  // never good enough
  scene.link.latency_ms = 60;
  scene.link.loss = 0;
  const SessionResult run = Session(scene).run();
  ASSERT_GT(run.refreshes.size(), 8u);
  int shortest = 1000;
  for (std::size_t i = 4; i < run.refreshes.size(); ++i)
    shortest = std::min(shortest, run.refreshes[i].linearized_tick - run.refreshes[i - 1].linearized_tick);
  EXPECT_EQ(shortest, 15);
}

/// Nodes of the patch of a tool that goes on at 0.05 m/s, at the third refresh.
std::vector<int> patch_told(double latency_ms, std::optional<double> told, double& recorded) {
  Scene scene = small_scene();
  scene.link.latency_ms = latency_ms;
  const Session session(scene);
  struct Records final : ModelObserver {
    void adopted(const PreparedLocalModel&) noexcept override {}
    bool look_back(const PreparedLocalModel&, int) override { return false; }
    void refreshed(const RefreshRecord& record) override { delay = record.delay; }
    double delay = -1;
  } records;
  BodySide body(session.body(), session.options());
  body.observe(&records);
  body.expect(told);
  std::vector<int> nodes;
  for (int tick = 0; tick <= 200; tick += 50) {
    std::vector<LocalReport> reports;
    const auto pose = [&](int i) { return Pose{Vec3(0.02 + 5e-5 * i, 0.025, 0.0245)}; };
    for (int i = tick - 50; i < tick && tick > 0; ++i) {
      reports.emplace_back().tick = i;
      reports.back().tools[0].pose = pose(i + 1);
    }
    const Pose at = pose(tick);
    nodes = body.refresh({tick, tick}, {&at, 1}, reports, nullptr, [] { return 0.0; })->model.patch.global_node;
  }
  body.finish();
  recorded = records.delay;
  return nodes;
}

TEST(BodySide, GoesByTheDelayThatItIsTold) {
  double at_once = 0, simulated = 0, told = 0;
  const std::vector<int> small = patch_told(0, {}, at_once), large = patch_told(200, {}, simulated);
  EXPECT_GT(large.size(), small.size());
  EXPECT_EQ(patch_told(0, 0.2, told), large);
  EXPECT_EQ(at_once, 0);
  EXPECT_EQ(simulated, 0.2);
  EXPECT_EQ(told, 0.2);
}

}  // namespace
}  // namespace kt
