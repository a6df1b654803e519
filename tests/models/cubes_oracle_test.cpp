// Cubes of a lattice with one gradient each, against their tetrahedra where the strain is uniform, against central
// differences, and against beams.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "io/solid/lattice.hpp"
#include "models/fem/element.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/lattice_scene.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01;

/// A turned block in cubes that it cuts: pieces of cubes of all kinds.
Mesh cut_lattice() {
  Mesh block = surface_of(kuhn_block(2, 2, 3, kEdge));
  const Mat3 turn = (Eigen::AngleAxisd(0.4, Vec3::UnitZ()) * Eigen::AngleAxisd(0.3, Vec3::UnitX())).toRotationMatrix();
  for (int i = 0; i < block.num_nodes(); ++i) node(block.x, i) = turn * node(block.x, i);
  return make_lattice(block, {.edge = 0.012});
}

std::unique_ptr<DeformableModel> body(const std::string& element, const std::string& material, double poisson,
                                      const ModelOptions& others = {}) {
  ModelOptions options = others;
  options.poisson = poisson;
  options.material = material;
  options.element = element;
  return make_model("fem", cut_lattice(), options);
}

class Cubes : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, Cubes, testing::ValuesIn([] {
                           std::vector<std::string> out;
                           for (const BackendInfo& b : material_backends()) out.push_back(b.name);
                           return out;
                         }()));

/// Near incompressibility, too, where the tetrahedra in cubes have another Poisson's ratio, and where all is in an
/// inclusion.
TEST_P(Cubes, HaveTheForcesOfTheirTetrahedraUnderAUniformStrain) {
  Mat3 F;
  F << 1.1, 0.2, 0, -0.05, 0.9, 0.1, 0.07, 0, 1.05;
  for (const auto& [poisson, stiffer] : {std::pair(-0.2, 1.0), {0.3, 1.0}, {0.3, 7.0}, {0.49, 1.0}}) {
    const ModelOptions damped{.damping_mass = 1, .damping_stiffness = 2e-3, .inclusions = {{Vec3::Zero(), 1, stiffer}}};
    const auto cubes = body("hex8", GetParam(), poisson, damped),
               tetrahedra = body("tet4", GetParam(), poisson, damped);
    State s = rest_state(cubes->own());
    for (int i = 0; i < static_cast<int>(s.x.size() / 3); ++i) {
      node(s.v, i) = 3 * F * Vec3(node(s.x, i));
      node(s.x, i) = F * Vec3(node(s.x, i));
    }
    const VectorX truth = force(tetrahedra->own(), s);
    EXPECT_GT(truth.lpNorm<Eigen::Infinity>(), 1e-3);
    EXPECT_LE((force(cubes->own(), s) - truth).lpNorm<Eigen::Infinity>(), 1e-10 * truth.lpNorm<Eigen::Infinity>())
        << poisson;
  }
}

TEST_P(Cubes, HaveTheGradientsOfTheirForceAsTangents) {
  const auto model =
      body("hex8", GetParam(), 0.4, {.damping_stiffness = 1e-3, .inclusions = {{Vec3(0, 0.01, 0.02), 0.01, 5}}});
  const DeformableModel& own = model->own();
  const State s = shaken(own, 0.1 * kEdge, 5);
  const Tangent tangent = own.tangent(s, TangentKind::exact);
  const auto by_x = [&](const VectorX& x) { return force(own, {0, x, s.v}); };
  const auto by_v = [&](const VectorX& v) { return force(own, {0, s.x, v}); };
  EXPECT_LE(relative_error(tangent.dfdx, central_differences(by_x, s.x, 1e-5 * kEdge)), 1e-6);
  EXPECT_LE(relative_error(tangent.dfdv, central_differences(by_v, s.v, 1e-3)), 1e-6);
}

/// Only turning and moving as a whole costs nothing: a cube of one gradient alone would have twelve more such motions.
TEST(Cubes, ResistEveryMotionButThatOfARigidBody) {
  const auto model = body("hex8", "linear", 0.3);
  const MatrixX K = -MatrixX(model->own().tangent(rest_state(model->own()), TangentKind::exact).dfdx);
  const VectorX values = symmetric_eigenvalues(0.5 * (K + K.transpose()));
  EXPECT_LT(std::abs(values[5]), 1e-9 * values[values.size() - 1]);
  EXPECT_GT(values[6], 1e-6 * values[values.size() - 1]);
}

/// By volume of material: 1 of them at 3 and 3 at 7.
TEST(Cubes, HaveTheMeanOfTheirTetrahedra) {
  ElementTable<4> table;
  table.points.resize(3);
  table.points[0].volume = 1;
  table.points[1].volume = 3;
  table.points[2].volume = 5;
  EXPECT_EQ(mean_of_cubes({3, 7, 4}, table, {0, 0, 1}), (std::vector<double>{6, 4}));
  EXPECT_TRUE(mean_of_cubes({}, table, {0, 0, 1}).empty());
}

TEST(Cubes, OfABodyThatIsNoLatticeAreRefusedInOneLine) {
  try {
    make_model("fem", kuhn_block(1, 1, 1, kEdge), {.element = "hex8"});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("object.body lattice"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace kt
