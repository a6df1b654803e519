// The force of coarse meshes over the continuum's, measured by presses at rest, and as contact_width.hpp expects it.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics/cells/contact_width.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/session/session.hpp"
#include "lab/study/press.hpp"
#include "models/model.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kYoung = 1e4, kPoisson = 0.3, kRadius = 0.008, kDepth = 0.0015, kThickness = 0.02;
constexpr double kFit = 0.10;  // the fit's own error at its worst place: 6 %

/// Mean force over a node, an edge's middle, a diagonal's middle and inside a face, over the truth.
double measured_factor(const std::string& element, int layers) {
  const double h = kThickness / layers;
  const Mesh mesh = kuhn_block(4 * layers, 4 * layers, layers, h);
  ModelOptions options{.young = kYoung, .poisson = kPoisson, .material = "neo_hookean", .element = element};
  if (element == "msd") options.element = "tet4";
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) options.fixed_nodes.push_back(i);
  const auto body = make_model(element == "msd" ? "msd" : "fem", mesh, options);
  double sum = 0;
  for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(0.5, 0, 0), Vec3(0.5, 0.5, 0), Vec3(1.0 / 3, 2.0 / 3, 0)}) {
    const Vec3 at = Vec3(2 * kThickness, 2 * kThickness, kThickness) + h * offset;
    const PressSite site{at + kRadius * Vec3::UnitZ(), at + (kRadius - kDepth) * Vec3::UnitZ(), kRadius};
    const PressResult r = press(*body, rest_state(*body), site, {.young = kYoung});
    EXPECT_TRUE(r.settled) << element << ' ' << layers;
    sum += r.force.z();
  }
  // On a bonded layer of 20 mm 0.0877 N. The neo-Hookean continuum has 0.0880 N: what large strains take, the contact
  // that moves along with the body gives (axisymmetric_press_oracle_test.cpp).
  return sum / 4 / press_axisymmetric({.thickness = kThickness, .radius = kRadius, .depth = kDepth, .cells = 16}).force;
}

TEST(ContactWidth, ForceFactorIsTheOneThatPressesMeasure) {
  const double contact = std::sqrt(kRadius * kDepth);
  for (const char* element : {"msd", "tet4", "tet10"})
    for (const int layers : {3, 4, 6}) {
      if (std::string(element) == "tet10" && layers > 4) continue;  // a minute
      const double measured = measured_factor(element, layers);
      const double expected = coarse_force_factor(element, kThickness / layers / contact);
      EXPECT_NEAR(expected / measured, 1, kFit) << element << ", " << layers << " layers: " << measured;
    }
}

TEST(ContactWidth, TellsTheFactorsOfTheTableInIssueThirtyOne) {
  const double ratio = 0.005 / std::sqrt(kRadius * kDepth);  // cells of 5 mm
  EXPECT_NEAR(coarse_force_factor("tet4", ratio), 2.04, 0.12);
  EXPECT_NEAR(coarse_force_factor("msd", ratio), 1.27, 0.12);
  EXPECT_NEAR(coarse_force_factor("tet10", ratio), 1.28, 0.12);
  EXPECT_TRUE(std::isnan(coarse_force_factor("layers", ratio)));
}

TEST(ContactWidth, RatioOfAFactorIsItsInverse) {
  for (const char* element : {"msd", "tet4", "tet10"})
    EXPECT_NEAR(coarse_force_factor(element, ratio_of_factor(element, 1.4)), 1.4, 1e-12);
}

/// meshes/block.msh has cells of 5 mm; the tool of 4 mm presses 2 mm.
TEST(ContactWidth, OfASessionIsThatOfItsCellsAndItsPress) {
  Scene scene = small_scene();
  scene.object.model.type = "fem";
  const Session session(scene);
  std::vector<Vec3> places;
  for (const TimedPoint& p : session.path()) places.push_back(p.x);
  const auto width = find_contact_width(session, places);
  ASSERT_TRUE(width);
  EXPECT_NEAR(width->cell, 0.005, 1e-9);
  EXPECT_NEAR(width->least, 0.005 / std::sqrt(0.004 * 0.002), 1e-6);
  ASSERT_EQ(session.predictions().size(), 1u);
  const std::string message = session.predictions()[0].message();
  for (const char* words :
       {"cells of 5 mm", "times the force of the continuum", "local.refine to auto (about 1.06 times)"})
    EXPECT_NE(message.find(words), std::string::npos) << message;
}

TEST(ContactWidth, LengthInTheCureHasItsUnit) {
  Scene scene = small_scene();
  scene.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
  scene.object.model.type = "fem";
  scene.tool.path.press_drag->at = std::array{0.0, 0.0};
  ContactWidth width{.cell = 0.007, .contact_radius = 0.004, .mean = 1.75};
  width.factor = 2;
  width.fine_edge = 0.00463;
  EXPECT_NE(coarse_mesh_finding(Session(scene), width).line().find("set local.refine to auto (about 1.06 times)"),
            std::string::npos);
  scene.global.self_contact = SelfContactSettings{};
  scene.global.integrator = "newton_euler";  // its cells cannot be refined
  const std::string message = coarse_mesh_finding(Session(scene), width).line();
  EXPECT_NE(message.find("max_edge to 0.00463 m (about 3 times the nodes"), std::string::npos) << message;
  const std::string slow = coarse_mesh_finding(Session(scene), width, 0.5).line();
  EXPECT_NE(slow.find("no longer in real time"), std::string::npos) << slow;
}

TEST(ContactWidth, IsNoneForAPointAndWhereTheToolStaysOutside) {
  const Session point(small_scene("point"));
  EXPECT_FALSE(find_contact_width(point, std::vector{point.path().back().x}));
  const Session sphere(small_scene());
  EXPECT_FALSE(find_contact_width(sphere, std::vector{Vec3(0, 0, 1)}));
}

}  // namespace
}  // namespace kt
