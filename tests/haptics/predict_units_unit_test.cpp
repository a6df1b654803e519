#include "haptics/predict/predict_units.hpp"

#include <gtest/gtest.h>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

SceneSizes organ() {
  SceneSizes s;
  s.body = {Vec3::Zero(), Vec3(0.12, 0.08, 0.04)};
  s.tool = Vec3::Constant(0.008);
  s.depth = 0.003;
  s.thickness = 0.04;
  return s;
}

std::string only(const Scene& scene, const SceneSizes& sizes) {
  const auto found = predict_units(scene, sizes);
  EXPECT_EQ(found.size(), 1u);
  return found.size() == 1 ? found[0].message() : "";
}

void expect_words(const std::string& line, const std::vector<std::string>& words) {
  for (const std::string& word : words) EXPECT_NE(line.find(word), std::string::npos) << line;
}

TEST(PredictUnits, AreNoneForAnOrgan) { EXPECT_TRUE(predict_units(Scene{}, organ()).empty()); }

TEST(PredictUnits, NameAMeshInMillimetresWithItsScale) {
  SceneSizes s = organ();
  s.body.max *= 1000;
  s.thickness *= 1000;
  expect_words(only(Scene{}, s), {"120 m long", "object.scale to 0.001", "mm", "0.12 m"});
  Scene sized;
  sized.object.size = 120;
  expect_words(only(sized, s), {"object.size"});
}

TEST(PredictUnits, NameABodyThatIsTooSmall) {
  SceneSizes s = organ();
  s.body.max *= 0.001;
  s.thickness = s.depth = 0;
  s.tool = Vec3::Constant(1e-5);
  s.mesh_unit = 0.001;
  expect_words(only(Scene{}, s), {"0.00012 m long", "object.scale to 1"});
}

TEST(PredictUnits, NameALargeToolADeepPressAndAModulusInKilopascal) {
  SceneSizes s = organ();
  s.tool = Vec3::Constant(0.3);
  expect_words(only(Scene{}, s), {"300 mm wide", "tool.radius"});
  s = organ();
  s.depth = 0.02;
  expect_words(only(Scene{}, s), {"20 mm is 0.5 of", "tool.path.press_drag.depth to 0.012"});
  Scene soft;
  soft.object.model.young = 8;
  expect_words(only(soft, organ()), {"8 Pa", "not kPa"});
  soft.object.model.young = 2e9;
  expect_words(only(soft, organ()), {"2e+09 Pa"});
}

/// The cure is the tool's own unit, or size, and not the body's, which is as usual.
TEST(PredictUnits, NameTheUnitOfAToolsMeshAndLeaveNeedlesAlone) {
  Scene scene;
  scene.tool.shape = "mesh";
  scene.tool.mesh = "jaw.off";
  SceneSizes s = organ();
  s.tool = {5, 8, 30};  // millimetres, taken as metres
  const std::string jaw = only(scene, s);
  expect_words(jaw, {"8000 mm wide", "set tool.scale to mm", "jaw.off"});
  for (const char* wrong : {"object.", "tool.radius"}) EXPECT_EQ(jaw.find(wrong), std::string::npos) << jaw;
  scene.tool.size = 30;
  expect_words(only(scene, s), {"set tool.size"});
  s.tool = {0.001, 0.001, 0.2};  // longer than the body, and thin
  EXPECT_TRUE(predict_units(scene, s).empty());
  scene.second_tool = scene.tool;
  s.second_tool = Vec3(0.3, 0.3, 0.3);
  expect_words(only(scene, s), {"second_tool: it is 300 mm wide", "second_tool.size"});
}

/// A tool is wide beside a body that is taken as too small: the body's unit is told, twice if need be.
TEST(PredictUnits, BlameTheBodyWhereItIsTheOneThatIsOff) {
  SceneSizes s = organ();
  s.body.max *= 0.01;
  s.thickness = s.depth = 0;
  s.mesh_unit = 0.01;
  const auto found = predict_units(Scene{}, s);
  ASSERT_EQ(found.size(), 2u);
  for (const Prediction& p : found) {
    expect_words(p.message(), {"object.scale to 1"});
    EXPECT_EQ(p.message().find("tool.radius"), std::string::npos) << p.message();
  }
}

TEST(PredictUnits, OfASessionMeasureTheThicknessUnderThePress) {
  Scene scene = small_scene();
  scene.tool.path.press_drag->depth = 0.008;  // of 20 mm
  const Session session(scene);
  const auto found = std::ranges::find(session.predictions(), "units", &Prediction::failure);
  ASSERT_NE(found, session.predictions().end());
  expect_words(found->message(), {"8 mm is 0.4 of", "20 mm"});
}

/// The block's cells are 5 mm: a ball of 20 mm touches 10 triangles, one of 0.5 m some 230.
TEST(PredictPlaces, OfALargeToolAreToldAndTooManyRefused) {
  const auto scene_of = [](double radius, double depth) {
    Scene scene = small_scene();
    scene.tool.radius = radius;
    scene.tool.path.press_drag.reset();
    scene.tool.path.waypoints = {{0, {0.03, 0.026, 0.021 + radius}}, {0.1, {0.03, 0.026, 0.02 - depth + radius}}};
    return scene;
  };
  const auto told = [](const Scene& scene) {
    const Session session(scene);
    return std::ranges::any_of(session.predictions(), [](const Prediction& p) {
      return p.message().find("and 40 places are resolved") != std::string::npos;
    });
  };
  EXPECT_FALSE(told(scene_of(0.02, 0.002)));
  EXPECT_TRUE(told(scene_of(0.12, 0.002)));  // 60 triangles of 12.5 mm^2 in a circle of sqrt(0.12 m 2 mm)
  EXPECT_THROW(Session(scene_of(0.5, 0.002)), InputError);
}

}  // namespace
}  // namespace kt
