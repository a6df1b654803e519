// What a scene file may say, and the one line a wrong one gives.
#include "io/scene/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr const char* kSmallest = R"({"object": {"mesh": "slab.off"}})";

/// The message of the error that `json` gives; empty when it is accepted.
std::string error_of(const std::string& json, const std::vector<std::string>& overrides = {}) {
  try {
    parse_scene(json, overrides, "a.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string set_error(const std::string& override_text) { return error_of(kSmallest, {override_text}); }

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// A folder of its own that goes away with the test.
class SceneFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() / (std::string("kt_scene_") + info->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

TEST(Scene, DefaultsAreThoseOfTheStructs) {
  Scene expected = default_scene();
  expected.object.mesh = "slab.off";
  EXPECT_EQ(parse_scene(kSmallest), expected);
  EXPECT_EQ(expected.seed, 1u);
  EXPECT_TRUE(expected.object.model.calibrate);
  EXPECT_TRUE(expected.tool.path.press_drag.has_value());
  EXPECT_TRUE(expected.object.fixed.below.has_value());
  EXPECT_FALSE(expected.object.size.has_value());
}

TEST(Scene, TakesTheLawPenaltyAsTheMethodOfThatName) {
  const Scene named = parse_scene(R"({"object": {"mesh": "m.off"}, "contact": {"law": "penalty"}})");
  EXPECT_EQ(named.local.method, "penalty");
  EXPECT_EQ(named.contact.law, "coulomb");
  EXPECT_THROW(
      parse_scene(R"({"object": {"mesh": "m.off"}, "contact": {"law": "penalty"}, "local": {"method": "hold"}})"),
      InputError);
}

TEST(Scene, EveryKeyIsRead) {
  const Scene s = parse_scene(R"({
    "title": "all", "duration": 2, "seed": 7,
    "object": {"mesh": "m.off", "size": 0.1, "fixed": {"box": [[0, 0, 0], [1, 2, 3]]},
      "tetrahedralize": {"backend": "tetgen", "max_volume": 1e-7, "quality": 1.5, "max_edge": 0.004}, "layers": {"count": 3, "thickness": 0.002},
      "body": "lattice", "lattice": {"nodes": 500},
      "gravity": [0, 1, -9.81],
      "model": {"type": "fem", "material": "linear", "element": "tet10", "consistent_mass": true, "young": 2e4, "poisson": 0.45, "density": 900,
                "damping": {"mass": 1, "stiffness": 0.1, "law": "rayleigh"}, "stiffness": 300, "damper": 0.5,
                "inclusions": [{"center": [0.05, 0.03, 0.02], "radius": 0.005, "stiffer": 5}, {"center": [0, 0, 0], "radius": 1, "stiffer": 0.5}]}},
    "tool": {"shape": "capsule", "radius": 0.001, "path": {"hand": {"stiffness": 1, "damping": 2, "mass": 3, "delay_ms": 4,
             "target": [[0, 1, 2, 3], [0.5, 4, 5, 6]]}}},
    "second_tool": {"shape": "point", "turn": [1, 0, 0], "path": {"waypoints": [[0, 1, 2, 3]]}},
    "contact": {"law": "paper_slide", "mu_static": 0.9, "mu_kinetic": 0.4, "metric": "mass", "penalty": {"stiffness": 150, "damping": 0.1},
      "stribeck": 0.02, "regions": [{"box": [[0, 0, 0], [1, 1, 1]], "mu": 0.8}, {"box": [[0, 0, 0], [2, 2, 2]], "mu_static": 0.3, "mu_kinetic": 0.2}],
      "surface": "h", "surface_levels": 3, "ridge_deg": 50},
    "global": {"rate_hz": 10, "integrator": "a", "solver": "f", "tolerance": 1e-4, "early_refresh": false, "look_ahead": false, "definite": false,
               "self_contact": {"mu": 0.1, "reach": 1e-4, "stiffness": 50, "creep": 2e-3}}, "local": {"rate_hz": 500, "method": "frozen", "reducer": "b", "rings": 2, "tolerance": 0.1, "budget_us": 90, "refresh_budget_ms": 25, "catch_up": false, "blend_ms": 3, "refine": "follow", "fineness": 0.5, "refine_nodes": 700, "passivity_damping": 0.5,
    "integrator": "c"}, "link": {"type": "d", "latency_ms": 5, "loss": 0.25, "charge_refreshes": "given", "refresh_ms": 40}, "collision": {"backend": "e"}})");
  EXPECT_EQ(s.title, "all");
  EXPECT_EQ(s.duration, 2.0);
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.object.size, 0.1);
  EXPECT_EQ((*s.object.fixed.box)[1], Vec3(1, 2, 3));
  EXPECT_FALSE(s.object.fixed.below.has_value());
  EXPECT_EQ(s.object.tetrahedralize, (SceneTetrahedralize{"tetgen", 1e-7, 1.5, 0.004}));
  EXPECT_EQ(s.object.layers, (SceneLayers{3, 0.002}));
  EXPECT_EQ(s.object.body, "lattice");
  EXPECT_EQ(s.object.lattice, (SceneLattice{{}, 500}));
  SceneModel model;
  model.type = "fem";
  model.material = "linear";
  model.element = "tet10";
  model.consistent_mass = true;
  model.young = 2e4;
  model.poisson = 0.45;
  model.density = 900;
  model.damping = {1, 0.1, "rayleigh"};
  model.stiffness = 300;
  model.damper = 0.5;
  model.calibrate = false;
  model.inclusions = {{Vec3(0.05, 0.03, 0.02), 0.005, 5}, {Vec3(0, 0, 0), 1, 0.5}};
  EXPECT_EQ(s.object.model, model);
  EXPECT_EQ(s.object.gravity, Vec3(0, 1, -9.81));
  EXPECT_EQ(s.tool.shape, "capsule");
  EXPECT_FALSE(s.tool.path.press_drag.has_value());
  EXPECT_EQ(s.tool.path.hand, (SceneHand{1, 2, 3, 4, {{0.0, Vec3(1, 2, 3)}, {0.5, Vec3(4, 5, 6)}}}));
  ASSERT_TRUE(s.second_tool.has_value());
  EXPECT_EQ(s.second_tool->shape, "point");
  EXPECT_EQ(s.second_tool->turn, Vec3(1, 0, 0));
  EXPECT_FALSE(s.second_tool->path.press_drag.has_value());
  EXPECT_EQ(s.second_tool->path.waypoints, (std::vector<Waypoint>{{0.0, Vec3(1, 2, 3)}}));
  EXPECT_EQ(s.contact,
            (ContactSettings{"paper_slide",
                             0.9,
                             0.4,
                             "mass",
                             {150, 0.1},
                             0.02,
                             {{{Vec3::Zero(), Vec3::Ones()}, 0.8, 0.8}, {{Vec3::Zero(), 2 * Vec3::Ones()}, 0.3, 0.2}},
                             "h",
                             3,
                             50}));
  EXPECT_EQ(s.global,
            (GlobalSettings{10, "a", "f", 1e-4, false, false, false, SelfContactSettings{0.1, 1e-4, 50, 2e-3}}));
  EXPECT_EQ(s.local, (LocalSettings{500, "b", 2, 0.1, 90, 25.0, false, 3, "follow", 0.5, 700, 0.5, "c", "frozen"}));
  EXPECT_EQ(s.link, (LinkSettings{"d", 5, 0.25, "given", 40.0}));
  EXPECT_EQ(s.collision.backend, "e");
}

TEST(Scene, OneFrictionCoefficientSetsBoth) {
  const Scene s = parse_scene(kSmallest, {"contact.mu=0.8"});
  EXPECT_EQ(s.contact.mu_static, 0.8);
  EXPECT_EQ(s.contact.mu_kinetic, 0.8);
}

TEST(Scene, SpringsAreGivenOrCalibrated) {
  EXPECT_FALSE(parse_scene(kSmallest, {"object.model.stiffness=20"}).object.model.calibrate);
  EXPECT_NE(set_error("object.model.calibrate=false").find("object.model.calibrate is false without stiffness"),
            std::string::npos);
  EXPECT_EQ(error_of(kSmallest, {"object.model.calibrate=false", "object.model.stiffness=20"}), "");
  EXPECT_EQ(error_of(kSmallest, {"object.model.calibrate=false", "object.model.type=fem"}), "")
      << "it has no springs: told by the session";
}

TEST(Scene, AScaleMayBeAUnit) {
  const std::pair<const char*, double> units[] = {{"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},
                                                  {"m", 1},     {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : units) {
    const Scene s = parse_scene(kSmallest, {std::string("object.scale=") + name, "tool.shape=mesh", "tool.mesh=t.off",
                                            std::string("tool.scale=") + name});
    EXPECT_EQ(s.object.scale, metres);
    EXPECT_EQ(s.tool.scale, metres);
    EXPECT_EQ(parse_scene(to_json(s)), s);
  }
  EXPECT_EQ(parse_scene(R"({"object": {"mesh": "a.off", "scale": "mm"}})").object.scale, 1e-3);
  EXPECT_EQ(set_error("object.scale=mn"),
            "--set object.scale=mn: object.scale is \"mn\", did you mean mm? (known: um, mm, cm, m, in, ft)");
  EXPECT_EQ(
      set_error("object.scale=0"),
      "--set object.scale=0: object.scale is 0, must be a number above 0, at most 1000 or one of um, mm, cm, m, in, ft "
      "(one mesh unit by name, or in m)");
  EXPECT_EQ(set_error("object.scale=[1]"),
            "--set object.scale=[1]: object.scale is [1], must be a number above 0, at most 1000 or one of um, mm, cm, "
            "m, in, ft "
            "(one mesh unit by name, or in m)");
}

TEST(Scene, AnEasedPathIsAskedFor) {
  EXPECT_EQ(parse_scene(kSmallest).tool.path.press_drag->ease, "none");
  EXPECT_EQ(parse_scene(kSmallest, {"tool.path.press_drag.ease=minimum_jerk"}).tool.path.press_drag->ease,
            "minimum_jerk");
  EXPECT_NE(set_error("tool.path.press_drag.ease=jerk").find("none, minimum_jerk"), std::string::npos);
}

TEST(Scene, SelfContactTakesStepsThatAreSolvedToTheEnd) {
  EXPECT_FALSE(parse_scene(kSmallest).global.self_contact.has_value());
  EXPECT_EQ(parse_scene(kSmallest).global.integrator, "implicit_euler");
  const Scene s = parse_scene(kSmallest, {"global.self_contact={}"});
  EXPECT_EQ(s.global.self_contact, SelfContactSettings{});
  EXPECT_EQ(s.global.integrator, "newton_euler");
  // Another one by name stays, for the session to refuse.
  EXPECT_EQ(parse_scene(kSmallest, {"global.self_contact={}", "global.integrator=sdirk2"}).global.integrator, "sdirk2");
}

TEST(Scene, AnEmptyFixedGroupClampsNothing) {
  const Scene s = parse_scene(kSmallest, {"object.fixed={}"});
  EXPECT_EQ(s.object.fixed, (SceneFixed{std::nullopt, std::nullopt, std::nullopt}));
}

TEST(Scene, MayHaveNoEnd) {
  const Scene scene = parse_scene(kSmallest, {"duration=null"});
  EXPECT_TRUE(scene.is_endless);
  EXPECT_EQ(scene.duration, Scene{}.duration);
  EXPECT_EQ(parse_scene(to_json(scene)), scene);
  EXPECT_FALSE(parse_scene(kSmallest, {"duration=null", "duration=2"}).is_endless);
}

TEST(Scene, CommentsAreAllowed) {
  const Scene s = parse_scene("// a slab\n{\"object\": /* its mesh */ {\"mesh\": \"slab.off\"} // end\n}");
  EXPECT_EQ(s.object.mesh, "slab.off");
}

TEST(Scene, WritesAndReadsItselfBack) {
  std::vector<std::vector<std::string>> variants = {
      {},
      {"object.size=0.1", "contact.mu_static=0.7", "contact.mu_kinetic=0.3", "object.model.stiffness=200"},
      {"object.scale=0.001", "object.fixed.nodes=[1, 5, 9]", "object.layers={}", "object.tetrahedralize={}"},
      {"tool.path.waypoints=[[0,0,0,0],[1.5,1e-3,0.1,-2]]", "object.fixed={}", "seed=9007199254740991"},
      {"second_tool.path.recording=c.csv", "second_tool.radius=0.002"},
      {"tool.path.recording=a \"b\".csv", "title=\xc3\xa9t\xc3\xa9", "object.fixed.box=[[0,0,0],[1,1,1]]"},
      {"tool.path.hand.target=[[0,0.1,0.2,0.3]]", "duration=0.1234567890123456", "object.model.damper=0.25"},
      {"global.self_contact={}"},
      {"global.self_contact.mu=0", "global.self_contact.reach=1e-4", "global.integrator=sdirk2"},
      {"contact.stribeck=0.05", "contact.regions=[{\"box\":[[0,0,0],[1,1,1]],\"mu\":0.2}]"},
      {"tool.path.press_drag.at=[0.02,0.05]", "object.model.calibrate=false", "object.model.stiffness=20"},
      {R"(object.model.inclusions=[{"center": [0.1, 0, 1e-3], "radius": 0.005, "stiffer": 5}])"}};
  for (const auto& overrides : variants) {
    const Scene scene = parse_scene(kSmallest, overrides);
    EXPECT_EQ(parse_scene(to_json(scene)), scene) << to_json(scene);
  }
  EXPECT_EQ(parse_scene(to_json(default_scene())), default_scene());
}

TEST(SceneOverride, ReplacesValuesAndMakesGroups) {
  const Scene s = parse_scene(kSmallest, {"object.model.young=2e4", "object.model.type=fem", "title=2024",
                                          "tool.path.press_drag.direction=[0, 1, 0]", "object.mesh=\"b.off\""});
  EXPECT_EQ(s.object.model.young, 2e4);
  EXPECT_EQ(s.object.model.type, "fem");
  EXPECT_EQ(s.title, "2024");  // a text key takes a number as text
  EXPECT_EQ(s.tool.path.press_drag->direction, Vec3(0, 1, 0));
  EXPECT_EQ(s.object.mesh, "b.off");
}

TEST(SceneOverride, TheLastOneHolds) { EXPECT_EQ(parse_scene(kSmallest, {"duration=2", "duration=3"}).duration, 3.0); }

TEST(SceneOverride, DropsTheKeysItExcludes) {
  const std::string file = R"({"object": {"mesh": "a.off", "size": 0.1}, "contact": {"mu": 0.5},
                               "tool": {"path": {"press_drag": {"depth": 0.01}}}})";
  const Scene s = parse_scene(file, {"object.scale=0.001", "contact.mu_static=0.9", "contact.mu_kinetic=0.6",
                                     "tool.path.waypoints=[[0,0,0,0]]"});
  EXPECT_FALSE(s.object.size.has_value());
  EXPECT_EQ(s.object.scale, 0.001);
  EXPECT_EQ(s.contact.mu_static, 0.9);
  EXPECT_FALSE(s.tool.path.press_drag.has_value());
}

TEST_F(SceneFile, FilesInsideAreRelativeToIt) {
  const std::string path =
      write("a.json", R"({"object": {"mesh": "../m/slab.off"}, "tool": {"path": {"recording": "r.csv"}}})");
  const Scene s = load_scene(path);
  EXPECT_EQ(s.object.mesh, (folder_.parent_path() / "m/slab.off").string());
  EXPECT_EQ(s.tool.path.recording, (folder_ / "r.csv").string());
  EXPECT_EQ(load_scene(path, {"object.mesh=/x/y.off"}).object.mesh, "/x/y.off");
}

TEST_F(SceneFile, ATypedMeshThatIsHereIsTakenFromHere) {
  const std::string here = write("here.off", "OFF");
  const std::string path = write("a.json", kSmallest);
  const std::string typed = std::filesystem::relative(here).string();
  EXPECT_EQ(load_scene(path, {"object.mesh=" + typed}).object.mesh, typed);
  EXPECT_EQ(load_scene(path, {"object.mesh=not_here.off"}).object.mesh, (folder_ / "not_here.off").string());
}

TEST_F(SceneFile, FilesThatCannotBeReadSaySo) {
  const auto error = [](const std::string& path) {
    try {
      load_scene(path);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(error("no_such.json"), "no_such.json: no such scene file, or it cannot be read");
  EXPECT_EQ(error(folder_.string()), folder_.string() + ": is a folder, not a scene file");
  const std::string empty_mesh = write("b.json", R"({"object": {"mesh": ""}})");
  EXPECT_EQ(error(empty_mesh), empty_mesh + ": object.mesh is empty: name a mesh file");
}

struct WrongScene {
  const char* json;
  const char* message;  ///< "..." at its end: the rest is a list of keys that may grow
};

/// The part of `error` that `message` speaks about.
std::string as_long_as(const std::string& message, const std::string& error) {
  return message.ends_with("...") ? error.substr(0, message.size() - 3) + "..." : error;
}

TEST(SceneError, WrongTextSaysLineAndColumn) {
  const WrongScene cases[] = {
      {"", "a.json:1:1: unexpected end of input; expected '[', '{', or a literal (a bracket not closed?)"},
      {"{\"object\": {\"mesh\": \"a\",\n  }\n}",
       "a.json:2:3: unexpected '}'; expected string literal (a comma too many before it?)"},
      {"{\"title\": \"a\"\n \"duration\": 1}",
       "a.json:2:11: unexpected string literal; expected '}' (a comma missing before it?)"},
      {"{\"duration\": 1e999}", "a.json:1:14: the number 1e999 is too large"},
      {"{\"duration\": nan}",
       "a.json:1:15: invalid literal; last read: '\"duration\": na' (words go in double quotes)"},
      {"{\"object\": {\"mesh\": \"a\"}, \"seed\": 1, \"seed\": 2}",
       "a.json: the key \"seed\" is given twice in one group { }"},
      {"[1]",
       "a.json: the scene is [1], must be a group { } with keys from title, duration, seed, object, tool, second_tool, "
       "contact, global, local, link, collision"},
  };
  for (const WrongScene& wrong : cases) EXPECT_EQ(as_long_as(wrong.message, error_of(wrong.json)), wrong.message);
}

TEST(SceneError, WrongValuesSayWhatIsAllowed) {
  const WrongScene cases[] = {
      {"{}", "a.json: object is missing"},
      {R"({"object": {}})",
       "a.json: object.mesh is missing (surface (OBJ OFF PLY STL) or tetrahedra (.node/.ele .msh .vtu .vtk .mesh), "
       "relative to "
       "the "
       "scene file)"},
      {R"({"object": {"mesh": "a", "modle": {}}})",
       "a.json: object.modle is not a key of a scene, did you mean model? (known here: mesh, size, ..."},
      {R"({"object": {"mesh": "a", "size": 1, "scale": 1}})",
       "a.json: object has both size and scale: give one of them"},
      {R"({"object": {"mesh": "a", "fixed": {"below": {}, "nodes": []}}})",
       "a.json: object.fixed has below, nodes: give one of them"},
      {R"({"object": {"mesh": "a"}, "tool": {"path": {}}})",
       "a.json: tool.path is empty, must have one of press_drag, waypoints, recording, hand, device"},
      {R"({"object": {"mesh": "a"}, "contact": {"mu": 1, "mu_kinetic": 1}})",
       "a.json: contact has both mu and mu_kinetic: give one of them"},
      {R"({"object": {"mesh": "a"}, "contact": {"mu_static": 1}})",
       "a.json: contact.mu_static needs mu_kinetic beside it"},
      {R"({"object": {"mesh": "a"}, "contact": {"mu_static": 0.2, "mu_kinetic": 0.4}})",
       "a.json: contact.mu_kinetic is 0.4, must be at most mu_static (0.2)"},
      {R"({"object": {"mesh": "a"}, "contact": {"stribeck": -1}})",
       "a.json: contact.stribeck is -1, must be a number at least 0, at most 100 (sliding speed over which mu_static "
       "falls to mu_kinetic, m/s; 0: at once)"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"mu": 1}]}})",
       "a.json: contact.regions[0].box is missing ([[min], [max]] at rest, m)"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"box": [[0,0,0],[1,1,1]]}]}})",
       "a.json: contact.regions[0] has no friction coefficient: give mu, or mu_static and mu_kinetic"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"box": [[0,0,0],[1,-1,1]], "mu": 1}]}})",
       "a.json: contact.regions[0].box has a max below its min: write [[min x, y, z], [max x, y, z]]"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"box": [[0,0,0],[1,1,1]], "mu_static": 0.2, "mu_kinetic": 0.4}]}})",
       "a.json: contact.regions[0].mu_kinetic is 0.4, must be at most mu_static (0.2)"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"box": [[0,0,0],[1,1,1]], "mu": 1, "mu_static": 0.2, "mu_kinetic": 0.1}]}})",
       "a.json: contact.regions[0] has both mu and mu_static: give one of them"},
      {R"({"object": {"mesh": "a"}, "contact": {"regions": [{"box": [[0,0,0],[1,1,1]], "mu": 1, "name": "skin"}]}})",
       "a.json: contact.regions[0].name is not a key of a scene..."},
  };
  for (const WrongScene& wrong : cases) EXPECT_EQ(as_long_as(wrong.message, error_of(wrong.json)), wrong.message);
}

TEST(SceneError, WrongOverridesSayWhichOne) {
  const WrongScene cases[] = {
      {"object.model.young=-5",
       "--set object.model.young=-5: object.model.young is -5, must be a number above 0, at most 1e+13 (Young's "
       "modulus, Pa)"},
      {"object.model.young=soft",
       "--set object.model.young=soft: object.model.young is \"soft\", must be a number above 0, at most 1e+13 "
       "(Young's "
       "modulus, Pa)"},
      {"object.model.young=1e999",
       "--set object.model.young=1e999: object.model.young is \"1e999\", must be a number above 0, at most 1e+13 "
       "(Young's modulus, Pa)"},
      {"object.model.poisson=0.5",
       "--set object.model.poisson=0.5: object.model.poisson is 0.5, must be a number above -1, below 0.5 (Poisson's "
       "ratio)"},
      {"object.modle.young=1",
       "--set object.modle.young=1: object.modle is not a key of a scene, did you mean model? (known here: mesh, size, "
       "..."},
      {"young=1",
       "--set young=1: young is not a key of a scene, did you mean object.model.young? (known here: title, duration, "
       "seed, object, tool, second_tool, contact, global, local, link, collision)"},
      {"contact.metric=identty",
       "--set contact.metric=identty: contact.metric is \"identty\", did you mean identity? (known: identity, mass, "
       "implicit)"},
      {"local.rings=1.5",
       "--set local.rings=1.5: local.rings is 1.5, must be a whole number at least 1, at most 100 (rings of triangles "
       "around the contact)"},
      {"tool.path.press_drag.direction=[1,0]",
       "--set tool.path.press_drag.direction=[1,0]: tool.path.press_drag.direction has 2 entries, must be a list of 3 "
       "numbers"},
      {"tool.path.press_drag.direction=[0,0,0]",
       "--set tool.path.press_drag.direction=[0,0,0]: tool.path.press_drag.direction is zero: which way does the tool "
       "go?"},
      {"tool.path.waypoints=[[0,0,0,0],[1,0,\"up\",0]]",
       "--set tool.path.waypoints=[[0,0,0,0],[1,0,\"up\",0]]: tool.path.waypoints[1][2] is \"up\", must be a number"},
      {"tool.path.waypoints=[[1,0,0,0],[1,0,0,0]]",
       "--set tool.path.waypoints=[[1,0,0,0],[1,0,0,0]]: tool.path.waypoints[1] has time 1 s after 1 s: times must "
       "increase"},
      {"tool.radius=0",
       "--set tool.radius=0: tool.radius is 0, must be above 0 for a sphere (or set tool.shape to point)"},
      {"object.fixed.box=[[0,0,1],[1,1,0]]",
       "--set object.fixed.box=[[0,0,1],[1,1,0]]: object.fixed.box has a max below its min: write [[min x, y, z], [max "
       "x, "
       "y, z]]"},
      {"object.model.calibrate=1",
       "--set object.model.calibrate=1: object.model.calibrate is 1, must be true or false (choose each spring so that "
       "the network matches young)"},
      {R"(object.model.inclusions=[{"center":[0,0,0],"radius":-1,"stiffer":5}])",
       R"(--set object.model.inclusions=[{"center":[0,0,0],"radius":-1,"stiffer":5}]: )"
       "object.model.inclusions[0].radius is -1, must be a number above 0, at most 1000 (m)"},
      {R"(object.model.inclusions=[{"center":[0,0,0],"radius":1,"stifer":5}])",
       R"(--set object.model.inclusions=[{"center":[0,0,0],"radius":1,"stifer":5}]: )"
       "object.model.inclusions[0].stifer is not a key of a scene, did you mean stiffer? (known here: center, radius, "
       "stiffer)"},
      {R"(object.model.inclusions=[{"center":[0,0],"radius":1,"stiffer":5}])",
       R"(--set object.model.inclusions=[{"center":[0,0],"radius":1,"stiffer":5}]: )"
       "object.model.inclusions[0].center has 2 entries, must be a list of 3 numbers"},
      {"object.model.inclusions=5",
       "--set object.model.inclusions=5: object.model.inclusions is 5, must be a list of groups { } with keys from "
       "center, radius, stiffer (balls that are stiffer or softer than the rest)"},
      {"global.rate_hz=2000",
       "--set global.rate_hz=2000: global.rate_hz is 2000, must be at most local.rate_hz (1000)"},
      {"global.self_contact.mu=-0.1",
       "--set global.self_contact.mu=-0.1: global.self_contact.mu is -0.1, must be a number at least 0, at most 100 "
       "(friction coefficient of the body with itself)"},
      {"global.self_contact.reach=0",
       "--set global.self_contact.reach=0: global.self_contact.reach is 0, must be a number above 0, at most 1 "
       "(distance from which on surfaces repel, m)"},
      {"global.self_contact.creep=1e999",
       "--set global.self_contact.creep=1e999: global.self_contact.creep is \"1e999\", must be a number above 0, at "
       "most 10 (speed below which friction is smoothed, m/s)"},
      {"global.self_contact.range=1",
       "--set global.self_contact.range=1: global.self_contact.range is not a key of a scene (known here: "
       "mu, reach, stiffness, creep)"},
      {"global.self_contact=true", "--set global.self_contact=true: global.self_contact is true, must be a group..."},
      {"duration.x=1", "--set duration.x=1: duration is a value, not a group with keys inside"},
      {"duration", "--set duration: write key=value, as in object.model.young=2e4"},
      {"=1", "--set =1: write key=value, as in object.model.young=2e4"},
      {"object..young=1", "--set object..young=1: the key has an empty part: write it as in object.model.young=2e4"},
      {"object.mesh.x=1", "--set object.mesh.x=1: object.mesh is a value, not a group with keys inside"},
  };
  for (const WrongScene& wrong : cases) EXPECT_EQ(as_long_as(wrong.message, set_error(wrong.json)), wrong.message);
}

TEST(SceneError, IsOneLine) {
  EXPECT_EQ(error_of("{\"title\": \"a\nb\"}").find('\n'), std::string::npos);
  EXPECT_EQ(set_error("object.model.type=[\"a\nb\"]").find('\n'), std::string::npos);
}

TEST(SceneKeys, HoldEveryKeyOfASavedScene) {
  const auto keys = known_scene_keys();
  for (const char* key : {"title", "seed", "object.mesh", "object.fixed.below.axis", "object.layers.count",
                          "object.model.damping.stiffness", "tool.path.hand.target", "contact.mu", "collision.backend"})
    EXPECT_NE(std::find(keys.begin(), keys.end(), key), keys.end()) << key;
}

TEST(SceneKeys, AreAllInTheManual) {
  const std::string manual = text_of(KT_SOURCE_DIR "/docs/scene.md");
  for (std::string key : known_scene_keys()) {
    if (key.rfind("second_tool.", 0) == 0) key = "second_tool";  // it has the keys of `tool`
    EXPECT_NE(manual.find("`" + key + "`"), std::string::npos) << key;
  }
}

TEST(SceneText, ControlCharactersDoNotBreakTheLineOfAMessage) {
  for (const auto& [json, override_text] : std::vector<std::pair<std::string, std::string>>{
           {R"({"a\nb": 1})", "title=x"}, {"{}", "a\nb=1"}, {"{}", "no\nvalue"}}) {
    try {
      parse_scene(json, {override_text});
      FAIL() << json;
    } catch (const InputError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
}

TEST(SceneFiles, OfTheProjectLoad) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(KT_SOURCE_DIR "/scenes"))
    if (entry.path().extension() == ".json") {
      EXPECT_NO_THROW(load_scene(entry.path().string())) << entry.path();
      ++count;
    }
  EXPECT_GE(count, 5);
}

}  // namespace
}  // namespace kt
