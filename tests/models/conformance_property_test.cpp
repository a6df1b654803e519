// What every model in models.def promises, whatever its physics. A new model is tested the moment its line exists.
#include <gtest/gtest.h>

#include "core/global/integrator.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01;

std::vector<std::string> available_models() {
  std::vector<std::string> names;
  for (const BackendInfo& b : model_backends())
    if (b.available) names.push_back(b.name);
  return names;
}

class EveryModel : public testing::TestWithParam<std::string> {
 protected:
  const Mesh mesh_ = kuhn_block(2, 2, 2, kEdge);
  const ModelOptions options_{.young = 5e3,
                              .density = 1050,
                              .damping_mass = 1,
                              .damping_stiffness = 2e-3,
                              .fixed_nodes = nodes_below(mesh_, 1e-6)};
  const std::unique_ptr<DeformableModel> model_ = make_model(GetParam(), mesh_, options_);

  State shaken(double strain) const {
    State s = rest_state(*model_);
    s.x += strain * kEdge * random_vector(s.x.size(), 1);
    s.v = 0.05 * random_vector(s.x.size(), 2);
    return s;
  }
  VectorX force(const State& s) const {
    VectorX out;
    model_->force(s, out);
    return out;
  }
};

TEST_P(EveryModel, KeepsItsMeshItsFixedNodesAndItsName) {
  EXPECT_EQ(model_->mesh(), mesh_);
  EXPECT_EQ(model_->fixed_nodes(), options_.fixed_nodes);
  EXPECT_EQ(model_->info().type, GetParam());
}

TEST_P(EveryModel, HasASymmetricPositiveDefiniteMassOfTheRightSum) {
  const MatrixX mass = model_->mass();
  EXPECT_EQ(mass, mass.transpose());
  EXPECT_GT(symmetric_eigenvalues(mass)[0], 0);
  const double expected = 3 * options_.density * 8 * std::pow(kEdge, 3);
  EXPECT_NEAR(mass.sum(), expected, 1e-12 * expected);
}

TEST_P(EveryModel, IsInEquilibriumAtRest) {
  EXPECT_LE(force(rest_state(*model_)).lpNorm<Eigen::Infinity>(), 1e-12 * options_.young * kEdge * kEdge);
}

TEST_P(EveryModel, GivesTheDerivativesOfItsForceAsExactTangent) {
  for (double strain : {0.0, 0.05, 0.3}) {
    const State s = shaken(strain);
    const Tangent t = model_->tangent(s, TangentKind::exact);
    const MatrixX dfdx = central_differences([&](const VectorX& x) { return force({0, x, s.v}); }, s.x, 1e-7);
    const MatrixX dfdv = central_differences([&](const VectorX& v) { return force({0, s.x, v}); }, s.v, 1e-3);
    EXPECT_LE(relative_error(t.dfdx, dfdx), 1e-6) << strain;
    EXPECT_LE(relative_error(t.dfdv, dfdv), 1e-6) << strain;
  }
}

TEST_P(EveryModel, GivesADefiniteTangentThatIsSymmetricPositiveSemidefinite) {
  State s = shaken(0.3);
  s.x *= 0.7;
  const Tangent t = model_->tangent(s, TangentKind::definite);
  for (const SparseMatrix* m : {&t.dfdx, &t.dfdv}) {
    const MatrixX k = -MatrixX(*m);
    EXPECT_LE(relative_error(k, k.transpose()), 1e-14);
    const VectorX values = symmetric_eigenvalues(0.5 * (k + k.transpose()));
    EXPECT_GE(values.minCoeff(), -1e-12 * values.maxCoeff());
  }
}

TEST_P(EveryModel, GivesTheSymmetricPartOfItsTangentAlone) {
  const State s = shaken(0.3);
  const Tangent exact = model_->tangent(s, TangentKind::exact), symmetric = model_->tangent(s, TangentKind::symmetric);
  const auto part = [](const SparseMatrix& m) { return MatrixX(0.5 * (MatrixX(m) + MatrixX(m).transpose())); };
  EXPECT_LE(relative_error(part(symmetric.dfdx), part(exact.dfdx)), 1e-13);
  EXPECT_LE(relative_error(symmetric.dfdv, exact.dfdv), 1e-13);
}

TEST_P(EveryModel, KeepsThePatternOfItsTangent) {
  const Tangent rest = model_->tangent(rest_state(*model_), TangentKind::exact);
  for (TangentKind kind : {TangentKind::exact, TangentKind::symmetric, TangentKind::definite}) {
    const Tangent t = model_->tangent(shaken(0.3), kind);
    for (const auto& [a, b] : {std::pair(&rest.dfdx, &t.dfdx), std::pair(&rest.dfdv, &t.dfdv)}) {
      ASSERT_TRUE(b->isCompressed());
      ASSERT_EQ(a->nonZeros(), b->nonZeros());
      EXPECT_TRUE(std::equal(a->innerIndexPtr(), a->innerIndexPtr() + a->nonZeros(), b->innerIndexPtr()));
    }
  }
}

TEST_P(EveryModel, LosesEnergyToItsDampersOnly) {
  const State s = shaken(0.0);
  const VectorX damping = force(s) - force({0, s.x, VectorX::Zero(s.v.size())});
  EXPECT_LT(s.v.dot(damping), 0);
}

TEST_P(EveryModel, StaysFiniteWhenNodesCollapseOrInvert) {
  for (double factor : {0.0, -0.5, 10.0}) {
    State s = shaken(0.0);
    s.x *= factor;
    EXPECT_TRUE(force(s).allFinite()) << factor;
    const Tangent t = model_->tangent(s, TangentKind::definite);
    EXPECT_TRUE(MatrixX(t.dfdx).allFinite() && MatrixX(t.dfdv).allFinite()) << factor;
  }
}

TEST_P(EveryModel, MadeTwiceGivesTheSameBits) {
  const auto again = make_model(GetParam(), mesh_, options_);
  const State s = shaken(0.2);
  VectorX f;
  again->force(s, f);
  EXPECT_EQ(f, force(s));
  EXPECT_EQ(MatrixX(again->tangent(s, TangentKind::exact).dfdx), MatrixX(model_->tangent(s, TangentKind::exact).dfdx));
}

TEST_P(EveryModel, FallsBackToRestUnderEveryIntegrator) {
  for (const BackendInfo& backend : integrator_backends()) {
    State s = shaken(0.1);
    for (int i : model_->fixed_nodes()) {
      node(s.x, i) = node(mesh_.x, i);
      node(s.v, i).setZero();
    }
    const double start = (s.x - mesh_.x).norm();
    const auto stepper = make_integrator(backend.name);
    const double dt = std::min(1e-3, 0.5 * stepper->stable_step(fastest_mode(*model_, rest_state(*model_))));
    for (double t = 0; t < 1; t += dt) stepper->step(*model_, VectorX::Zero(s.x.size()), dt, s);
    EXPECT_LE((s.x - mesh_.x).norm(), 0.1 * start) << backend.name;
    for (int i : model_->fixed_nodes()) EXPECT_EQ(Vec3(node(s.x, i)), Vec3(node(mesh_.x, i))) << backend.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EveryModel, testing::ValuesIn(available_models()),
                         [](const auto& test) { return test.param; });

TEST(MakeModel, NamesTheKnownModelsForAnUnknownOne) {
  const std::string what = message([] { make_model("msdd", kuhn_block(1, 1, 1, 1), {}); });
  EXPECT_EQ(what.rfind("unknown model \"msdd\": did you mean \"msd\"? (known: ", 0), 0u) << what;
  for (const BackendInfo& b : model_backends()) EXPECT_NE(what.find(b.name), std::string::npos);
}

TEST(MakeModel, RefusesEachOptionOutsideItsRangeAndNamesIt) {
  const Mesh mesh = kuhn_block(1, 1, 1, 1);
  const double nan = std::nan("");
  const std::vector<std::pair<std::string, ModelOptions>> wrong{
      {"model.young = 0", {.young = 0}},
      {"model.young = nan", {.young = nan}},
      {"model.poisson = 0.5", {.poisson = 0.5}},
      {"model.poisson = -1", {.poisson = -1}},
      {"model.density = -1", {.density = -1}},
      {"model.damping.mass = -1", {.damping_mass = -1}},
      {"model.damping.stiffness = nan", {.damping_stiffness = nan}},
      {"model.stiffness = 0", {.stiffness = 0.0}},
      {"model.damper = -1", {.damper = -1.0}},
      {"model: fixed node 8 is outside 0 .. 7", {.fixed_nodes = {8}}},
      {"model: fixed node -1 is outside 0 .. 7", {.fixed_nodes = {-1}}},
  };
  for (const std::string& name : available_models())
    for (const auto& [text, options] : wrong) {
      const std::string what = message([&, o = options] { make_model(name, mesh, o); });
      EXPECT_EQ(what.rfind(text, 0), 0u) << name << ": " << what;
    }
}

TEST(MakeModel, RefusesInfiniteDampingAndMeshesWithoutSubstance) {
  const double inf = std::numeric_limits<double>::infinity();
  const Mesh mesh = kuhn_block(1, 1, 1, 1);
  Mesh broken = mesh, lone = mesh;
  broken.x[5] = inf;
  lone.x.conservativeResize(27);
  lone.x.tail(3).setConstant(5);
  for (const std::string& name : available_models()) {
    EXPECT_THROW(make_model(name, mesh, {.damping_mass = inf}), InputError) << name;
    EXPECT_THROW(make_model(name, mesh, {.damping_stiffness = inf}), InputError) << name;
    EXPECT_THROW(make_model(name, mesh, {.damper = inf}), InputError) << name;
    EXPECT_THROW(make_model(name, Mesh{}, {}), InputError) << name;
    EXPECT_THROW(make_model(name, broken, {}), InputError) << name;
    EXPECT_THROW(make_model(name, lone, {}), InputError) << name;
  }
}

TEST(MakeModel, TakesFixedNodesInAnyOrderAndTwice) {
  for (const std::string& name : available_models())
    EXPECT_EQ(make_model(name, kuhn_block(1, 1, 1, 1), {.fixed_nodes = {3, 1, 3, 0}})->fixed_nodes(),
              (std::vector<int>{0, 1, 3}))
        << name;
}

}  // namespace
}  // namespace kt
