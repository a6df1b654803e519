// Which elements an inclusion holds, what springs make of it, and what wrong ones say: hand values.
#include "models/inclusions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "models/model.hpp"
#include "models/msd/springs.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

/// The unit cube's corner, and its mirror image below: they share nodes 0 1 2. Centroids at z = +-1/4.
Mesh two_corners() {
  Mesh mesh = one_tetrahedron(1);
  mesh.x.conservativeResize(15);
  mesh.x.tail(3) = Vec3(0, 0, -1);
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.triangles = boundary_triangles(mesh.tetrahedra);
  return mesh;
}

const Vec3 kUpper(0.25, 0.25, 0.25), kLower(0.25, 0.25, -0.25);

TEST(StiffnessFactors, AreThoseOfTheLastInclusionThatHoldsTheCentroid) {
  const Mesh mesh = two_corners();
  EXPECT_TRUE(stiffness_factors(mesh, {}).empty());
  EXPECT_EQ(stiffness_factors(mesh, {{kUpper, 0.1, 5}}), (std::vector<double>{5, 1}));
  EXPECT_EQ(stiffness_factors(mesh, {{kUpper, 1, 5}, {kLower, 0.1, 0.5}}), (std::vector<double>{5, 0.5}));
  EXPECT_EQ(stiffness_factors(mesh, {{kLower, 0.1, 0.5}, {kUpper, 1, 5}}), (std::vector<double>{5, 5}));
  EXPECT_EQ(stiffness_factors(mesh, {{kUpper, 0.49, 2}}), (std::vector<double>{2, 1}));  // 0.5 to the other
  EXPECT_EQ(stiffness_factors(mesh, {{kUpper, 0.51, 2}}), (std::vector<double>{2, 2}));
}

TEST(StiffnessFactors, OfABodyWithoutTetrahedraAreThoseOfItsTriangles) {
  const Mesh membrane = sheet(2, 1, 1);
  const std::vector<double> factors = stiffness_factors(membrane, {{Vec3(0.5, 0.5, 0), 0.3, 4}});
  ASSERT_EQ(factors.size(), 4u);
  EXPECT_EQ(std::ranges::count(factors, 4.0), 2);
}

TEST(Inclusions, AreCountedInTheModelsDescription) {
  for (const BackendInfo& model : model_backends()) {
    EXPECT_EQ(make_model(model.name, two_corners(), {})->info().parameters.at("stiffened_elements"), 0) << model.name;
    const auto one = make_model(model.name, two_corners(), {.inclusions = {{kUpper, 0.1, 5}}});
    EXPECT_EQ(one->info().parameters.at("stiffened_elements"), 1) << model.name;
  }
}

TEST(Stiffen, GivesASpringTheMeanFactorOfTheVolumeAroundIt) {
  Mesh mesh = two_corners();
  node(mesh.x, 4) = Vec3(0, 0, -3);  // three times the volume of the other
  std::vector<Spring> springs = make_springs(mesh);
  for (Spring& s : springs) s.stiffness = 10;
  stiffen(mesh, {}, springs);
  EXPECT_EQ(springs[0].stiffness, 10);
  stiffen(mesh, {5, 1}, springs);
  for (const Spring& s : springs) {
    const double expected = s.b == 3 ? 50 : s.b == 4 ? 10 : 20;  // shared: 10 (1 * 5 + 3 * 1) / 4
    EXPECT_NEAR(s.stiffness, expected, 1e-12) << s.a << " " << s.b;
  }
}

TEST(Stiffen, OfAMembraneWeighsAreas) {
  const Mesh membrane = sheet(1, 1, 1);  // two triangles that share the diagonal
  std::vector<Spring> springs = make_springs(membrane);
  for (Spring& s : springs) s.stiffness = 1;
  stiffen(membrane, {3, 1}, springs);
  double sum = 0;
  for (const Spring& s : springs) sum += s.stiffness;
  EXPECT_NEAR(sum, 2 * 3 + 2 * 1 + 2, 1e-12);
}

TEST(Inclusions, OutsideTheirRangeSayWhichAndWhat) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  const Inclusion good{kUpper, 0.3, 5};
  const std::vector<std::pair<std::string, Inclusion>> wrong{
      {".radius = 0: must be a finite number > 0 [m]", {kUpper, 0, 5}},
      {".radius = -1: must be a finite number > 0 [m]", {kUpper, -1, 5}},
      {".radius = nan: must be a finite number > 0 [m]", {kUpper, kNan, 5}},
      {".radius = inf: must be a finite number > 0 [m]", {kUpper, kInf, 5}},
      {".stiffer = 0: must be a number > 0, at most 1e+06", {kUpper, 1, 0}},
      {".stiffer = nan: must be a number > 0, at most 1e+06", {kUpper, 1, kNan}},
      {".stiffer = 1e+07: must be a number > 0, at most 1e+06", {kUpper, 1, 1e7}},
      {".center = (nan, 0, 0): must be three finite numbers [m]", {Vec3(kNan, 0, 0), 1, 5}},
  };
  for (const BackendInfo& model : model_backends())
    for (const auto& [what, inclusion] : wrong)
      EXPECT_EQ(message([&, in = inclusion] {
                  make_model(model.name, two_corners(), {.inclusions = {good, in}});
                }),
                "object.model.inclusions[1]" + what)
          << model.name;
}

TEST(Inclusions, ThatHoldNoElementSayWhereTheMeshIs) {
  const std::string expected =
      "object.model.inclusions[1]: the ball around (1, 1, 1) of radius 0.3 m holds the middle of no element: the "
      "nearest is 1.29904 m from its center, the mesh is (0, 0, -1) to (1, 1, 1) m; move or enlarge it, or refine the "
      "mesh";
  for (const BackendInfo& model : model_backends())
    EXPECT_EQ(message([&] {
                make_model(model.name, two_corners(), {.inclusions = {{kUpper, 0.3, 5}, {Vec3(1, 1, 1), 0.3, 5}}});
              }),
              expected)
        << model.name;
}

}  // namespace
}  // namespace kt
