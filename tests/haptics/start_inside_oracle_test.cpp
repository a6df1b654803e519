// A tool that starts inside the body: it comes to the force that it would have had if it had come from outside, by
// small steps, whatever its shape and the body's model; and out through what can move, not through what is clamped.
#include <gtest/gtest.h>

#include <fstream>

#include "collision/held/surface_contacts.hpp"
#include "haptics/session/session.hpp"
#include "haptics/tick/way_out.hpp"
#include "io/files/child_process.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kTop = 0.02;       // [m] of the block
constexpr double kDuration = 0.35;  // [s]
const Vec3 kTarget(0.03, 0.026, 0);

struct Case {
  const char* shape;
  const char* model;
  double height;  // of the reference point [m]
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.shape << ' ' << c.model; }

/// A box, and a mesh of four triangles.
Mesh tool_mesh(const std::string& shape) {
  if (shape == "tetrahedron") {
    Mesh out;
    out.x.resize(12);
    out.x << 0, 0, -6e-3, 6e-3, 0, 4e-3, -3e-3, 5.2e-3, 4e-3, -3e-3, -5.2e-3, 4e-3;
    out.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
    return out;
  }
  return kuhn_block(1, 1, 1, 8e-3);
}

Scene scene_of(const Case& c, bool from_above, const PrivateFolder& folder) {
  Scene scene = small_scene();
  scene.duration = kDuration;
  scene.object.model.type = c.model;
  scene.object.model.damping.mass = 40;
  scene.contact.mu_static = scene.contact.mu_kinetic = 0;  // with friction, the force at rest depends on the way there
  SceneTool& tool = scene.tool;
  tool.shape = c.shape;
  if (tool.shape == "capsule") {
    tool.radius = 0.004;
    tool.length = 0.01;
    tool.turn = Vec3(1.5707963, 0, 0);
  } else if (tool.shape != "point" && tool.shape != "sphere") {
    tool.mesh = folder / "tool.off";
    Mesh surface = tool_mesh(c.shape);
    surface.tetrahedra.clear();
    save_mesh(tool.mesh, surface);
    tool.shape = "mesh";
    tool.radius = 5e-4;
  }
  const Vec3 at = kTarget + c.height * Vec3::UnitZ(), above = kTarget + (kTop + 0.009) * Vec3::UnitZ();
  tool.path = {.press_drag = {},
               .waypoints = from_above ? std::vector<Waypoint>{{0, above}, {0.2, at}, {kDuration, at}}
                                       : std::vector<Waypoint>{{0, at}, {kDuration, at}},
               .recording = {},
               .hand = {},
               .device = {}};
  return scene;
}

Vec3 mean_of_the_last(std::span<const LocalFrame> frames) {
  constexpr std::size_t kCount = 30;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = frames.size() - kCount; i < frames.size(); ++i) sum += frames[i].force;
  return sum / kCount;
}

class StartsInside : public testing::TestWithParam<Case> {};

TEST_P(StartsInside, ComesBySmallStepsToTheForceOfOneThatCameFromOutside) {
  const PrivateFolder folder;
  const SessionResult in = Session(scene_of(GetParam(), false, folder)).run();
  const Vec3 expected = mean_of_the_last(Session(scene_of(GetParam(), true, folder)).run().tools[0].frames);
  const Vec3 found = mean_of_the_last(in.tools[0].frames);
  ASSERT_GT(expected.z(), 0.02);
  EXPECT_LT((found - expected).norm(), 0.1 * expected.norm()) << found.transpose() << " for " << expected.transpose();
  Vec3 last = Vec3::Zero();
  double most = 0;
  int pushed = 0;
  for (const LocalFrame& f : in.tools[0].frames) {
    if (f.flags & kPushedOut) {
      EXPECT_LE((f.force - last).norm(), 0.1 + 0.05 * last.norm() + 1e-12) << "at " << f.t;
      ++pushed;
    }
    EXPECT_FALSE(f.flags & (kRigidContact | kNotFinite)) << "at " << f.t;
    last = f.force;
    most = std::max(most, f.force.norm());
  }
  EXPECT_GE(pushed, 55);
  EXPECT_LT(most, 2 * expected.norm());
  EXPECT_LT(in.tools[0].penetration.back(), 1e-5);
}

// Tools with corners in springs are left out: there the way decides where the body rests, see RestsOfSprings below.
INSTANTIATE_TEST_SUITE_P(ShapesAndModels, StartsInside,
                         testing::Values(Case{"point", "msd", kTop - 0.003}, Case{"point", "fem", kTop - 0.003},
                                         Case{"sphere", "msd", kTop - 0.001}, Case{"sphere", "fem", kTop - 0.001},
                                         Case{"capsule", "msd", kTop - 0.001}, Case{"capsule", "fem", kTop - 0.001},
                                         Case{"box", "fem", kTop}, Case{"tetrahedron", "fem", kTop}),
                         [](const auto& of) { return std::string(of.param.shape) + "_" + of.param.model; });

/// A tetrahedron that starts inside springs ends with 0.283 N up and 0.10 N aside, from outside with 0.279 N and 0.04
/// N; a box rests at 0.713 N, from outside at 0.693 N. Each is a shape that the whole body bears: springs under a
/// corner rest to one side of it or to the other. Here with the body's own forces, which know of no local model: all
/// that is away from the tool is in balance, and what is left over is the force that the tool has.
struct RestCase {
  const char* shape;
  bool from_above;
  double duration, up;  // [s], [N]
};

void PrintTo(const RestCase& c, std::ostream* out) { *out << c.shape << (c.from_above ? " from above" : " inside"); }

class RestsOfSprings : public testing::TestWithParam<RestCase> {};

TEST_P(RestsOfSprings, AreInBalanceOverTheWholeBody) {
  constexpr double kRest = 0.01, kFar = 0.015;  // of the force; [m] from the tool: its size, and a cell
  const RestCase& c = GetParam();
  const PrivateFolder folder;
  Scene scene = scene_of({c.shape, "msd", kTop}, c.from_above, folder);
  scene.duration = c.duration;
  scene.tool.path.waypoints->back().t = c.duration;
  Session session(scene);
  SessionOptions options;
  options.snapshot_times = {c.duration};
  const SessionResult run = session.run(options);
  const Vec3 on_tool = mean_of_the_last(run.tools[0].frames);
  EXPECT_NEAR(on_tool.z(), c.up, kRest * c.up);
  ASSERT_EQ(run.snapshots.size(), 1u);
  const State state{0, run.snapshots[0].x, VectorX::Zero(run.snapshots[0].x.size())};
  VectorX force;
  session.model().force(state, force);
  for (const int i : session.model().fixed_nodes()) node(force, i).setZero();
  std::vector<char> is_outside(static_cast<std::size_t>(force.size() / 3));
  for (const Triangle& t : session.surface().triangles)
    for (const int v : t) is_outside[static_cast<std::size_t>(v)] = 1;
  Vec3 sum = Vec3::Zero();
  double most = 0;
  for (int i = 0; i < force.size() / 3; ++i) {
    sum += node(force, i);
    const bool may_touch =
        is_outside[static_cast<std::size_t>(i)] && (node(state.x, i) - run.snapshots[0].tools[0]).norm() < kFar;
    if (!may_touch) most = std::max(most, node(force, i).norm());
  }
  EXPECT_LT((sum - on_tool).norm(), kRest * on_tool.norm()) << sum.transpose() << " for " << on_tool.transpose();
  EXPECT_LT(most, kRest * on_tool.norm());
}

INSTANTIATE_TEST_SUITE_P(UnderCorners, RestsOfSprings,
                         testing::Values(RestCase{"tetrahedron", true, 0.5, 0.2786},
                                         RestCase{"tetrahedron", false, 0.5, 0.2828},
                                         RestCase{"box", false, 1.2, 0.7132}));

/// What the warning says is what the first ticks do: baselines have no way out of their own.
TEST(StartsInsideWarning, SaysWhatTheMethodDoes) {
  const PrivateFolder folder;
  const auto is_touching = [](const LocalFrame& f) { return f.mode != ContactMode::free; };
  for (const auto& [method, touches, words] :
       {std::tuple{"multirate", true, "pushed off it"}, std::tuple{"penalty", false, "no contact is looked for"},
        std::tuple{"frozen", false, "no contact is looked for"}, std::tuple{"legacy", true, "touching there"}}) {
    Scene scene = scene_of({"sphere", "fem", kTop - 0.002}, false, folder);
    scene.duration = 0.02;
    scene.local.method = method;
    if (method == std::string("legacy")) scene.local.reducer = "wall";  // it takes no other
    Session session(scene);
    const auto& predictions = session.predictions();
    EXPECT_TRUE(std::ranges::any_of(predictions, [&](const Prediction& p) {
      return p.message().find(words) != std::string::npos;
    })) << method;
    const SessionResult run = session.run();
    EXPECT_EQ(std::ranges::any_of(run.tools[0].frames, is_touching), touches) << method;
  }
}

bool says_inside(const Scene& scene, const std::string& key) {
  const Session session(scene);
  return std::ranges::any_of(session.predictions(), [&](const Prediction& p) {
    return p.message().starts_with(key + ": the tool starts ") && p.message().find("inside") != std::string::npos;
  });
}

/// A capsule that lies 1 mm over the block by its recording, and would stand 4 mm inside by tool.turn.
TEST(StartsInsideWarning, TakesTheOrientationOfARecording) {
  const PrivateFolder folder;
  Scene scene = small_scene("capsule");
  scene.tool.radius = 0.004;
  scene.tool.length = 0.01;
  scene.tool.path.press_drag.reset();
  scene.tool.path.recording = folder / "lying.csv";
  const auto write = [&](const char* turn) {
    std::ofstream out(*scene.tool.path.recording);
    out << "t,x,y,z,qw,qx,qy,qz\n";
    for (int i = 0; i <= 300; ++i) out << 1e-3 * i << ",0.03,0.026,0.025," << turn << '\n';
  };
  write("0.70710678,0,0.70710678,0");
  EXPECT_FALSE(says_inside(scene, "tool.path"));
  write("1,0,0,0");
  EXPECT_TRUE(says_inside(scene, "tool.path"));
}

TEST(StartsInsideWarning, IsSaidOfTheSecondToolToo) {
  Scene scene = small_scene();
  scene.second_tool = scene.tool;
  scene.second_tool->path.press_drag.reset();
  scene.second_tool->path.waypoints = {{0, {0.045, 0.026, 0.018}}, {0.3, {0.045, 0.026, 0.018}}};
  EXPECT_TRUE(says_inside(scene, "second_tool.path"));
  EXPECT_FALSE(says_inside(scene, "tool.path"));
}

/// Nearest to the clamped bottom, to a side, and outside.
TEST(WayOut, IsTheShortestThroughWhatCanMove) {
  const Session session(small_scene());
  const Mesh& body = session.model().mesh();
  const WayOutSearch search(session.surface(), body.num_nodes(), session.model().fixed_nodes());
  const ToolShape ball{ToolShape::Kind::sphere, 0.004};
  const auto out = [&](const Vec3& at) { return search.find(body.x, ball, at, Quaternion::Identity(), 0, 0); };
  const auto normal = [&](const WayOut& way) { return face_normal(search.whole(), body.x, way.triangle); };
  const auto up = out({0.03, 0.026, 0.008});  // 8 mm over the bottom, 12 mm below the top
  ASSERT_TRUE(up);
  EXPECT_NEAR(normal(*up).z(), 1, 1e-9);
  EXPECT_NEAR(up->depth, 0.012 + 0.004, 1e-9);
  const auto aside = out({0.005, 0.026, 0.01});
  ASSERT_TRUE(aside);
  EXPECT_NEAR(normal(*aside).x(), -1, 1e-9);
  EXPECT_NEAR(aside->depth, 0.005 + 0.004, 1e-9);
  EXPECT_FALSE(out({0.03, 0.026, kTop + 0.0041}));
  EXPECT_TRUE(out({0.03, 0.026, kTop + 0.0039}));
  EXPECT_FALSE(out({0.03, 0.026, -0.001}).has_value() && normal(*out({0.03, 0.026, -0.001})).z() < 0);
}

}  // namespace
}  // namespace kt
