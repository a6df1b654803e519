// Bodies with inclusions against homogeneous ones, central differences, bars in series and dense eigenvalues.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/global/integrator.hpp"
#include "core/linear/free_dofs.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01, kYoung = 1e4;
constexpr double kRoundoff = 1e-12;    // relative
constexpr double kDifferences = 1e-6;  // relative

struct Kind {
  std::string model, material, element;
};

std::vector<Kind> kinds() {
  std::vector<Kind> out{{"msd", "calibrated", ""}, {"msd", "given", ""}};
  for (const BackendInfo& b : material_backends())
    for (const char* element : {"tet4", "tet10"}) out.push_back({"fem", b.name, element});
  return out;
}

/// @param stiffer  of the whole body, without inclusions
std::unique_ptr<DeformableModel> body(const Kind& kind, const Mesh& mesh, ModelOptions options, double stiffer = 1) {
  options.young = stiffer * kYoung;
  if (kind.model == "fem") {
    options.material = kind.material;
    options.element = kind.element;
  } else if (kind.material == "given") {
    options.stiffness = stiffer * 40;
  }
  return make_model(kind.model, mesh, options);
}

/// Two overlapping balls, one stiffer and one softer, in a block of 2 x 2 x 2 cubes.
const std::vector<Inclusion> kTwo{{Vec3(0.4, 0.5, 0.5) * kEdge, 0.7 * kEdge, 7},
                                  {Vec3(1.2, 1, 1) * kEdge, 0.6 * kEdge, 0.3}};

class InclusionsTest : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(All, InclusionsTest, testing::ValuesIn(kinds()), [](const auto& p) {
  return p.param.model + "_" + p.param.material + (p.param.element.empty() ? "" : "_") + p.param.element;
});

TEST_P(InclusionsTest, OverTheWholeBodyAreAStifferBody) {
  const Mesh mesh = kuhn_block(2, 2, 2, kEdge);
  const ModelOptions options{.damping_mass = 2, .damping_stiffness = 1e-3};
  ModelOptions with = options;
  with.inclusions = {{Vec3::Zero(), 1, 5}};
  const auto included = body(GetParam(), mesh, with), stiff = body(GetParam(), mesh, options, 5);
  EXPECT_EQ(MatrixX(included->mass()), MatrixX(stiff->mass()));
  const State s = shaken(*stiff, 0.15 * kEdge, 5);
  EXPECT_LE(relative_error(force(*included, s), force(*stiff, s)), kRoundoff);
  for (TangentKind kind : {TangentKind::exact, TangentKind::symmetric, TangentKind::definite}) {
    const Tangent a = included->tangent(s, kind), b = stiff->tangent(s, kind);
    EXPECT_LE(relative_error(a.dfdx, b.dfdx), kRoundoff);
    EXPECT_LE(relative_error(a.dfdv, b.dfdv), kRoundoff);
  }
}

TEST_P(InclusionsTest, HaveTangentsThatAreTheGradientsOfTheForce) {
  for (double strain : {0.0, 0.1})
    for (double damping : {0.0, 1e-3}) {
      const auto model = body(GetParam(), kuhn_block(2, 2, 2, kEdge),
                              {.damping_mass = 2, .damping_stiffness = damping, .inclusions = kTwo});
      const State s = shaken(*model, strain * kEdge, 5);
      const Tangent tangent = model->tangent(s, TangentKind::exact);
      const auto by_x = [&](const VectorX& x) { return force(*model, {0, x, s.v}); };
      const auto by_v = [&](const VectorX& v) { return force(*model, {0, s.x, v}); };
      EXPECT_LE(relative_error(tangent.dfdx, central_differences(by_x, s.x, 1e-5 * kEdge)), kDifferences) << strain;
      EXPECT_LE(relative_error(tangent.dfdv, central_differences(by_v, s.v, 1e-3)), kDifferences) << strain;
    }
}

TEST_P(InclusionsTest, LeaveTheBodyAtRestAndItsTangentsDefinite) {
  const auto model = body(GetParam(), kuhn_block(2, 2, 2, kEdge), {.damping_stiffness = 1e-3, .inclusions = kTwo});
  EXPECT_LE(force(*model, rest_state(*model)).lpNorm<Eigen::Infinity>(), 1e-11 * kYoung * kEdge * kEdge);
  const Tangent tangent = model->tangent(shaken(*model, 0.2 * kEdge, 3), TangentKind::definite);
  for (const SparseMatrix& m : {tangent.dfdx, tangent.dfdv}) {
    const MatrixX k = -MatrixX(m);
    EXPECT_LE(relative_error(k, k.transpose()), kRoundoff);
    const VectorX values = symmetric_eigenvalues(k);
    EXPECT_GE(values.minCoeff(), -1e-10 * values.maxCoeff());
  }
}

/// The fastest mode, which the stable step comes from, is the heterogeneous body's.
TEST_P(InclusionsTest, ShortenTheStableStep) {
  if (GetParam().element == "tet10") return;  // the same code on three times the nodes
  const Mesh mesh = kuhn_block(2, 2, 2, kEdge);
  const ModelOptions options{.fixed_nodes = nodes_below(mesh, 1e-6)};
  ModelOptions with = options;
  with.inclusions = {{Vec3(1, 1, 1) * kEdge, 0.8 * kEdge, 9}};
  const auto soft = body(GetParam(), mesh, options), mixed = body(GetParam(), mesh, with);
  const FreeDofs free = make_free_dofs(mesh.num_nodes(), mixed->fixed_nodes());
  const State rest = rest_state(*mixed);
  const MatrixX K = -MatrixX(gather(free, mixed->tangent(rest, TangentKind::symmetric).dfdx)),
                M = MatrixX(gather(free, mixed->mass()));
  const double omega = std::sqrt(generalized_eigenvalues(0.5 * (K + K.transpose()), M).maxCoeff());
  const double found = fastest_mode(*mixed, rest).omega, before = fastest_mode(*soft, rest).omega;
  EXPECT_NEAR(found, omega, 0.02 * omega);
  EXPECT_GT(found, 1.2 * before);
  EXPECT_LE(found, 3.001 * before);  // sqrt(9): Rayleigh's quotient
}

/// Columns of material over one another, without Poisson's effect: a spring of E1 A / L1 on one of E2 A / L2.
TEST_P(InclusionsTest, InSeriesAreSofterThanEither) {
  if (GetParam().model != "fem") return;  // a network of springs is no bar of an exact stiffness
  constexpr double kStiffer = 5, kStretch = 1e-6;
  const int layers = 5, stiff_layers = 2;
  const Mesh mesh = kuhn_block(2, 2, layers, kEdge);
  // A ball so large that its top is flat: below the boundary between the layers.
  const double radius = 10, top = stiff_layers * kEdge;
  std::vector<int> ends;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (const double z = mesh.x[3 * i + 2]; z < 1e-9 || z > layers * kEdge - 1e-9) ends.push_back(i);
  const auto model =
      body(GetParam(), mesh,
           {.poisson = 0, .fixed_nodes = ends, .inclusions = {{Vec3(kEdge, kEdge, top - radius), radius, kStiffer}}});
  State s = rest_state(*model);
  const double pull = kStretch * layers * kEdge;
  std::vector<int> upper;
  for (int i : model->fixed_nodes())
    if (model->mesh().x[3 * i + 2] > 0.5 * layers * kEdge) upper.push_back(i);
  for (int i : upper) s.x[3 * i + 2] += pull;
  const auto equilibrium = make_integrator("quasistatic");
  equilibrium->step(*model, VectorX::Zero(s.x.size()), 0, s);
  ASSERT_EQ(equilibrium->statistics().not_converged, 0);
  const VectorX f = force(*model, s);
  double held = 0;
  for (int i : upper) held -= f[3 * i + 2];
  const double area = 4 * kEdge * kEdge;
  const double compliance =
      (stiff_layers * kEdge / (kStiffer * kYoung) + (layers - stiff_layers) * kEdge / kYoung) / area;
  const double off = held / pull * compliance - 1;
  std::printf("two layers in series: stiffness off by %.1e\n", off);
  EXPECT_NEAR(off, 0, 1e-5);  // the materials' curves over a stretch of 1e-6
}

}  // namespace
}  // namespace kt
