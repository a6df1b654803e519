// The oracle of presses against what is known in closed form: it is the truth of other tests.
#include "tests/support/axisymmetric_press.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/mesh/mesh_io.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "lab/study/press.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMesh = 0.003;  // of the force: sixteen cells in the contact's radius, a layer of finite size

double plane_modulus(const AxisymmetricPress& p) { return p.young / (1 - p.poisson * p.poisson); }

double hertz(const AxisymmetricPress& p) {
  return 4.0 / 3 * plane_modulus(p) * std::sqrt(p.radius) * std::pow(p.depth, 1.5);
}

/// A sphere so far from flat that it is no paraboloid, on a half space: Segedin 1957.
double segedin(const AxisymmetricPress& p) {
  const double r = p.radius;
  const auto log_of = [&](double a) { return std::log((r + a) / (r - a)); };
  double low = 0, high = r;
  while (high - low > 1e-12 * r) {
    const double a = 0.5 * (low + high);
    (0.5 * a * log_of(a) < p.depth ? low : high) = a;
  }
  return 0.5 * plane_modulus(p) * ((low * low + r * r) * log_of(low) - 2 * low * r);
}

/// A bonded layer over Hertz: Dimitriadis et al. 2002, eq. 12.
double dimitriadis(const AxisymmetricPress& p) {
  const double nu = p.poisson, chi = std::sqrt(p.radius * p.depth) / p.thickness;
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu);
  const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
  return 1 - 2 * a / kPi * chi + std::pow(2 * a / kPi * chi, 2) -
         8 / std::pow(kPi, 3) * (a * a * a + 4 * kPi * kPi / 15 * b) * std::pow(chi, 3) +
         16 * a / std::pow(kPi, 4) * (a * a * a + 3 * kPi * kPi / 5 * b) * std::pow(chi, 4);
}

TEST(AxisymmetricPress, OnAHalfSpaceIsHertzAndSegedin) {
  for (const double poisson : {0.0, 0.3, 0.45}) {
    const AxisymmetricPress p{.poisson = poisson, .thickness = 0.4, .width = 0.4, .depth = 5e-6, .cells = 16};
    const AxisymmetricPressed r = press_axisymmetric(p);
    EXPECT_NEAR(r.force / hertz(p), 1, kMesh) << poisson;
    EXPECT_NEAR(r.contact_radius, std::sqrt(p.radius * p.depth), 0.07 * std::sqrt(p.radius * p.depth));  // a cell
    EXPECT_LT(r.violation, 1e-9);
  }
  const AxisymmetricPress deep{.thickness = 4, .width = 4, .cells = 16};  // 0.19 of its radius
  EXPECT_NEAR(press_axisymmetric(deep).force / segedin(deep), 1, kMesh);
  EXPECT_LT(segedin(deep) / hertz(deep), 0.985);  // so the sphere's own shape is seen
}

TEST(AxisymmetricPress, OnALayerIsDimitriadis) {
  for (const double poisson : {0.3, 0.45})
    for (const double chi : {0.02, 0.05, 0.1}) {
      const double contact = std::sqrt(0.008 * 5e-6);
      const AxisymmetricPress p{
          .poisson = poisson, .thickness = contact / chi, .width = 20 * contact / chi, .depth = 5e-6, .cells = 16};
      EXPECT_NEAR(press_axisymmetric(p).force / hertz(p) / dimitriadis(p), 1, kMesh) << poisson << ' ' << chi;
    }
}

/// The layer that meshes are measured on (docs/accuracy_and_speed.md).
TEST(AxisymmetricPress, DoesNotChangeWithItsOwnMesh) {
  const double fine = press_axisymmetric({.cells = 32}).force;
  EXPECT_NEAR(press_axisymmetric({.cells = 16}).force / fine, 1, 1e-3);
  EXPECT_NEAR(press_axisymmetric({.width = 0.2, .cells = 32}).force / fine, 1, 1e-3);  // its sides are far away
  EXPECT_NEAR(fine, 0.0877, 1e-4);
}

/// The press that `kilotouch chart` compares meshes on, by its truth's mesh and material.
double press_on_the_graded_pad(const std::string& material) {
  const Mesh surface = load_mesh(KT_SOURCE_DIR "/meshes/pad_graded.off");
  const Mesh mesh = tetrahedralize(surface, {.max_volume = 1e-6});
  ModelOptions options{.young = 1e4, .poisson = 0.3, .material = material, .element = "tet10"};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) options.fixed_nodes.push_back(i);
  const auto body = make_model("fem", mesh, options);
  const Vec3 touched(0.025, 0.025, 0.02);
  const PressSite site{touched + 0.008 * Vec3::UnitZ(), touched + 0.0065 * Vec3::UnitZ(), 0.008};
  const PressResult r = press(*body, rest_state(*body), site, {.young = 1e4});
  EXPECT_TRUE(r.settled) << material;
  return r.force.z();
}

TEST(AxisymmetricPress, IsWhatTheTruthOfTheChartComesTo) {
  const auto all = tetrahedralizers();
  if (std::ranges::none_of(all, &BackendInfo::available)) GTEST_SKIP() << "needs a tetrahedralizer";
  AxisymmetricPress round{.width = std::sqrt(0.05 * 0.05 / kPi), .cells = 16};  // of the pad's area
  const double hertzian = press_axisymmetric(round).force;
  round.follows = true;
  const double linear = press_axisymmetric(round).force;
  EXPECT_NEAR(linear / hertzian, 1.047, 0.005);  // what it makes that the contact moves: 1.5 mm of 8
  EXPECT_NEAR(press_on_the_graded_pad("linear") / linear, 1, 0.02);           // 1.006
  EXPECT_NEAR(press_on_the_graded_pad("neo_hookean") / linear, 0.965, 0.02);  // 0.969; 0.9616 with edges of 1 mm
}

}  // namespace
}  // namespace kt
