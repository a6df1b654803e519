// A sphere pressed into a block against Hertz.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/refine_surface.hpp"
#include "lab/study/press.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

constexpr double kYoung = 1e4, kPoisson = 0.3, kRadius = 0.01;
const Vec3 kTouched(0.061, 0.0605, 0.06);

PressSite site(double depth) {
  return {kTouched + kRadius * Vec3::UnitZ(), kTouched + (kRadius - depth) * Vec3::UnitZ(), kRadius};
}

/// A block of 0.12 x 0.12 x 0.06 m, clamped below; `edge` [m] of its surface's triangles at the contact.
std::unique_ptr<DeformableModel> block(const std::string& element, double edge) {
  const Mesh coarse = kuhn_block(4, 4, 2, 0.03);
  const SurfaceSize size{.centre = kTouched, .radius = 2 * edge, .edge = edge, .growth = 0.8};
  const Mesh surface = refine_surface({coarse.x, boundary_triangles(coarse.tetrahedra), {}}, size, 20000);
  const Mesh mesh = tetrahedralize(surface, {.max_volume = 1e-5, .quality = 1.8});
  ModelOptions options{.young = kYoung, .poisson = kPoisson, .material = "neo_hookean", .element = element};
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) options.fixed_nodes.push_back(i);
  return make_model("fem", mesh, options);
}

PressResult press(const DeformableModel& model, double depth) {
  return press(model, rest_state(model), site(depth), {.young = kYoung});
}

double over_hertz(const PressResult& r, double depth) {
  return r.force.z() / (4.0 / 3 * kYoung / (1 - kPoisson * kPoisson) * std::sqrt(kRadius) * std::pow(depth, 1.5));
}

class Press : public testing::Test {
 protected:
  void SetUp() override {
    const auto all = tetrahedralizers();
    if (std::ranges::none_of(all, &BackendInfo::available)) GTEST_SKIP() << "needs a tetrahedralizer";
  }
};

TEST_F(Press, ASmallSphereOnABigBlockFollowsHertz) {
  constexpr double kDepth = 0.0005;
  const double contact = site(kDepth).contact_radius();
  constexpr double kFinite = 0.07;  // triangles of a third of the contact radius, a block 27 radii deep: 1.054
  const auto fine = block("tet10", contact / 3);
  const PressResult r = press(*fine, kDepth);
  ASSERT_TRUE(r.settled);
  EXPECT_NEAR(over_hertz(r, kDepth), 1, kFinite);
  EXPECT_LT(r.force.head<2>().norm(), 0.01 * r.force.z());
  EXPECT_LT(r.overlap, 0.02 * kDepth);
  // What it is there for: to tell a body that is too stiff.
  const PressResult stiff = press(*block("tet4", contact), kDepth);
  ASSERT_TRUE(stiff.settled);
  EXPECT_GT(over_hertz(stiff, kDepth), 1.3);
}

TEST_F(Press, DeepEnoughForTheCentreToPassTheSurfaceItStillPushesOut) {
  for (const double depth : {kRadius, 1.5 * kRadius}) {
    const PressResult r = press(*block("tet4", 0.3 * kRadius), depth);
    ASSERT_TRUE(r.settled);
    EXPECT_GT(r.force.z(), 0.3 * kYoung * kRadius * depth);  // Hertz, roughly
  }
}

TEST_F(Press, EndsWhenAsked) {
  const auto body = block("tet4", 0.3 * kRadius);
  int asked = 0;
  EXPECT_THROW(press(*body, rest_state(*body), site(0.002), {.young = kYoung, .stop = [&] { return ++asked > 2; }}),
               RunError);
  EXPECT_EQ(asked, 3);
}

}  // namespace
}  // namespace kt
