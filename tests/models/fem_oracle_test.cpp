// Finite elements against energy, central differences, exact integrals, patch tests and the laws of mechanics.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/global/integrator.hpp"
#include "core/linear/sparse_solver.hpp"
#include "models/fem/element.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01, kYoung = 1e4, kPoisson = 0.4, kDensity = 1000;
constexpr double kDifferences = 1e-6;  // relative

struct Kind {
  std::string material, element;
};

std::vector<Kind> kinds() {
  std::vector<Kind> out;
  for (const BackendInfo& b : material_backends())
    for (const char* element : {"tet4", "tet10"}) out.push_back({b.name, element});
  return out;
}

std::unique_ptr<DeformableModel> body(const Kind& kind, Mesh mesh, ModelOptions options = {}) {
  options.young = kYoung;
  options.poisson = kPoisson;
  options.density = kDensity;
  options.material = kind.material;
  options.element = kind.element;
  return make_model("fem", std::move(mesh), options);
}

class FemTest : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(All, FemTest, testing::ValuesIn(kinds()),
                         [](const auto& p) { return p.param.material + "_" + p.param.element; });

TEST_P(FemTest, TangentsAreTheGradientsOfTheForce) {
  for (double strain : {0.0, 0.15, 0.3})  // of the edge; at 0.3 elements are inside out
    for (double damping : {0.0, 1e-3}) {  // without: symmetric
      const auto model =
          body(GetParam(), kuhn_block(1, 1, 1, kEdge), {.damping_mass = 2, .damping_stiffness = damping});
      const State s = shaken(*model, strain * kEdge, 5);
      const Tangent tangent = model->tangent(s, TangentKind::exact);
      const auto by_x = [&](const VectorX& x) { return force(*model, {0, x, s.v}); };
      const auto by_v = [&](const VectorX& v) { return force(*model, {0, s.x, v}); };
      EXPECT_LE(relative_error(tangent.dfdx, central_differences(by_x, s.x, 1e-5 * kEdge)), kDifferences) << strain;
      EXPECT_LE(relative_error(tangent.dfdv, central_differences(by_v, s.v, 1e-3)), kDifferences) << strain;
    }
}

/// One tetrahedron: a batch of one; two bodies in one mesh; a rotated numbering: nodes do not ascend in the elements.
TEST_P(FemTest, TangentsOfOddBodiesAreTheGradientsOfTheForceToo) {
  const Mesh one = one_tetrahedron(kEdge);
  Mesh two = one;
  two.x.conservativeResize(24);
  two.x.tail(12) = one.x + Vec3(0.1, 0, 0).replicate(4, 1);
  two.tetrahedra.push_back({7, 6, 4, 5});
  for (const Triangle& t : one.triangles) two.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  if (!(tetrahedron_volume(two.x, two.tetrahedra[1]) > 0)) std::swap(two.tetrahedra[1][2], two.tetrahedra[1][3]);
  for (const Mesh& mesh : {one, two}) {
    const auto model = body(GetParam(), mesh, {.damping_stiffness = 1e-3});
    const State s = shaken(*model, 0.1 * kEdge, 5);
    const auto by_x = [&](const VectorX& x) { return force(*model, {0, x, s.v}); };
    EXPECT_LE(relative_error(model->tangent(s, TangentKind::exact).dfdx, central_differences(by_x, s.x, 1e-5 * kEdge)),
              kDifferences);
  }
}

TEST_P(FemTest, TangentsIntoUsedStorageAreThoseIntoNew) {
  const auto model = body(GetParam(), kuhn_block(2, 2, 2, kEdge), {.damping_mass = 2, .damping_stiffness = 1e-3});
  Tangent used;
  for (unsigned seed = 0; seed < 6; ++seed) {
    const State s = shaken(*model, 0.15 * kEdge, seed);
    const TangentKind kind = seed % 2 ? TangentKind::definite : TangentKind::exact;
    model->update_tangent(s, kind, used);
    const Tangent fresh = model->tangent(s, kind);
    EXPECT_EQ(MatrixX(used.dfdx), MatrixX(fresh.dfdx)) << seed;
    EXPECT_EQ(MatrixX(used.dfdv), MatrixX(fresh.dfdv)) << seed;
  }
}

/// Force and stiffness at x by a plain loop over the elements and their points.
template <int N>
std::pair<VectorX, MatrixX> sums_over_elements(const ElementTable<N>& table, const Material& material,
                                               const VectorX& x) {
  VectorX f = VectorX::Zero(x.size());
  MatrixX dfdx = MatrixX::Zero(x.size(), x.size());
  const auto points = static_cast<std::size_t>(table.points_per_element);
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const std::array<int, N>& nodes = table.nodes[i / points];
    const auto& [g, volume] = table.points[i];
    Mat3 F = Mat3::Zero();
    for (int a = 0; a < N; ++a) F += Vec3(node(x, nodes[a])) * g.col(a).transpose();
    const Mat3 P = material.stress(F);
    const Mat9 dP = material.tangent(F);
    for (int a = 0; a < N; ++a) {
      node(f, nodes[a]) -= volume * P * g.col(a);
      for (int b = 0; b < N; ++b)
        for (int j = 0; j < 3; ++j)
          for (int l = 0; l < 3; ++l)
            dfdx.block<3, 3>(3 * nodes[a], 3 * nodes[b]) -= volume * g(j, a) * g(l, b) * dP.block<3, 3>(3 * j, 3 * l);
    }
  }
  return {f, dfdx};
}

TEST_P(FemTest, ForceAndTangentOfSeveralSlabsAreTheSumsOverTheElements) {
  const Mesh mesh = kuhn_block(3, 3, 9, kEdge);
  const auto model = body(GetParam(), mesh);
  const auto material = make_material(GetParam().material, lame(kYoung, kPoisson));
  const State s = shaken(*model, 0.1 * kEdge, 3);
  const auto [f, dfdx] = GetParam().element == "tet4"
                             ? sums_over_elements(make_linear_elements(mesh), *material, s.x)
                             : sums_over_elements(make_quadratic_elements(mesh), *material, s.x);
  EXPECT_LE(relative_error(force(*model, s), f), 1e-11);
  EXPECT_LE(relative_error(model->tangent(s, TangentKind::exact).dfdx, dfdx), 1e-11);
}

TEST_P(FemTest, DefiniteTangentIsDefinite) {
  const auto model = body(GetParam(), kuhn_block(1, 1, 1, kEdge), {.damping_stiffness = 1e-3});
  State s = shaken(*model, 0.15 * kEdge, 5);
  for (int i = 0; i < model->mesh().num_nodes(); ++i) s.x[3 * i + 2] *= 0.5;
  const Tangent tangent = model->tangent(s, TangentKind::definite);
  for (const SparseMatrix& m : {tangent.dfdx, tangent.dfdv}) {
    const MatrixX dense = -MatrixX(m);
    EXPECT_LE((dense - dense.transpose()).norm(), 1e-12 * dense.norm());
    EXPECT_GE(symmetric_eigenvalues(dense)[0], -1e-10 * dense.norm());
  }
}

TEST_P(FemTest, MomentumIsConservedAndTurningGivesNoForce) {
  const auto model = body(GetParam(), kuhn_block(2, 1, 1, kEdge));
  const VectorX f = force(*model, shaken(*model, 0.15 * kEdge, 3));
  Vec3 sum = Vec3::Zero();
  double largest = 0;
  for (int i = 0; i < model->mesh().num_nodes(); ++i) {
    sum += node(f, i);
    largest = std::max(largest, node(f, i).norm());
  }
  EXPECT_LE(sum.norm(), 1e-12 * largest);
  if (GetParam().material == "linear") return;
  State turned = rest_state(*model);
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (int i = 0; i < model->mesh().num_nodes(); ++i) node(turned.x, i) = R * node(turned.x, i) + Vec3(0.1, 0.2, 0.3);
  const double off = force(*model, turned).lpNorm<Eigen::Infinity>() / (kYoung * kEdge * kEdge);
  std::printf("turned by 63 degrees: force over E edge^2 %.1e\n", off);
  EXPECT_LE(off, 1e-10);
}

/// Irons' patch test: a distorted patch whose outer nodes follow an affine map; the inner nodes find it, with the
/// material's own stress everywhere.
TEST_P(FemTest, PatchTest) {
  Mesh mesh = kuhn_block(2, 2, 2, kEdge);
  const int inner = 13;  // the middle node of 3 x 3 x 3
  node(mesh.x, inner) += Vec3(0.2, -0.15, 0.1) * kEdge;
  const auto model = body(GetParam(), mesh);
  Mat3 F;
  F << 1.1, 0.05, 0, -0.04, 0.95, 0.1, 0.02, 0, 1.05;
  State s = rest_state(*model);
  for (int i = 0; i < model->mesh().num_nodes(); ++i) node(s.x, i) = F * node(s.x, i);
  const VectorX f = force(*model, s);
  std::vector<char> on_surface(static_cast<std::size_t>(model->mesh().num_nodes()), 0);
  for (const Triangle& t : model->mesh().triangles)
    for (int v : t) on_surface[v] = 1;
  const Mat3 P = make_material(GetParam().material, lame(kYoung, kPoisson))->stress(F);
  Mat3 virial = Mat3::Zero();  // sum of f X^T = -V P
  for (int i = 0; i < model->mesh().num_nodes(); ++i) {
    if (!on_surface[i]) {
      EXPECT_LE(node(f, i).norm(), 1e-10 * kYoung * kEdge * kEdge);
    }
    virial += node(f, i) * node(model->mesh().x, i).transpose();
  }
  const double volume = 8 * kEdge * kEdge * kEdge;
  const double off = (virial + volume * P).norm() / (volume * P.norm());
  std::printf("patch test: stress off by %.1e\n", off);
  EXPECT_LE(off, 1e-10);
}

TEST_P(FemTest, MassAndGravity) {
  const Vec3 g(0.3, 0, -9.81);
  for (bool consistent : {false, true}) {
    const auto model = body(GetParam(), kuhn_block(2, 1, 1, kEdge), {.consistent_mass = consistent, .gravity = g});
    const double total = kDensity * 2 * kEdge * kEdge * kEdge;
    const VectorX ones = VectorX::Ones(model->mass().rows());
    EXPECT_NEAR(ones.dot(model->mass() * ones), 3 * total, 1e-12 * total);
    EXPECT_GT(symmetric_eigenvalues(model->mass())[0], 0);
    if (!consistent) {
      EXPECT_EQ(model->mass().nonZeros(), model->mass().rows());
    }
    Vec3 weight = Vec3::Zero();
    const VectorX f = force(*model, rest_state(*model));
    for (int i = 0; i < model->mesh().num_nodes(); ++i) weight += node(f, i);
    EXPECT_LE((weight - total * g).norm(), 1e-10 * total * g.norm());
  }
}

TEST_P(FemTest, ConsistentMassHasTheMomentsOfTheBody) {
  // x^T M x with x linear in space is exact for both elements: the second moment of the block.
  const auto model = body(GetParam(), kuhn_block(2, 2, 2, kEdge), {.consistent_mass = true});
  VectorX x = VectorX::Zero(model->mass().rows());
  for (int i = 0; i < model->mesh().num_nodes(); ++i) x[3 * i] = model->mesh().x[3 * i];
  const double length = 2 * kEdge;
  const double exact = kDensity * length * length * std::pow(length, 3) / 3;
  EXPECT_NEAR(x.dot(model->mass() * x), exact, 1e-12 * exact);
}

TEST_P(FemTest, EdgeNodesOfFixedEdgesAreFixed) {
  const Mesh mesh = kuhn_block(1, 1, 1, kEdge);
  const auto model = body(GetParam(), mesh, {.fixed_nodes = nodes_below(mesh, 0.1 * kEdge)});
  EXPECT_EQ(model->fixed_nodes(), nodes_below(model->mesh(), 0.1 * kEdge));
}

/// Nominal stress of a bar stretched along z with free sides, by hand.
double bar_stress(const std::string& material, double stretch) {
  if (material == "stvk") return kYoung * stretch * 0.5 * (stretch * stretch - 1);  // Hooke's law in the Green strain
  if (material != "neo_hookean") return kYoung * (stretch - 1);
  // The sides s from P_xx = 0, by bisection: m (1 - 1/(I + 1)) s + l (J - alpha) s z = 0, I = 2 s^2 + z^2, J = s^2 z.
  const double mu = kYoung / (2 * (1 + kPoisson)), lambda = kYoung * kPoisson / ((1 + kPoisson) * (1 - 2 * kPoisson));
  const double m = 4.0 / 3.0 * mu, l = lambda + 5.0 / 6.0 * mu, alpha = 1 + 0.75 * m / l, z = stretch;
  const auto stress = [&](double s, bool side) {
    const double I = 2 * s * s + z * z, J = s * s * z;
    return m * (1 - 1 / (I + 1)) * (side ? s : z) + l * (J - alpha) * (side ? s * z : s * s);
  };
  double low = 0.8, high = 1.1;
  for (int i = 0; i < 100; ++i) (stress(0.5 * (low + high), true) > 0 ? high : low) = 0.5 * (low + high);
  return stress(low, false);
}

TEST_P(FemTest, UniaxialBar) {
  const double stretch = 1.1;
  const Mesh mesh = kuhn_block(1, 1, 1, kEdge);
  const auto model = body(GetParam(), mesh);
  // Newton on the free entries: z of both ends is given, and rigid motion is taken away at one corner.
  State s = rest_state(*model);
  std::vector<int> free;
  for (int i = 0; i < model->mesh().num_nodes(); ++i) {
    const Vec3 x = node(model->mesh().x, i);
    const bool end = x[2] < 1e-9 || x[2] > kEdge - 1e-9;
    if (x[2] > kEdge - 1e-9) s.x[3 * i + 2] = stretch * kEdge;
    if (x[0] > 1e-9) free.push_back(3 * i);
    if (x[1] > 1e-9) free.push_back(3 * i + 1);
    if (!end) free.push_back(3 * i + 2);
  }
  for (int iteration = 0; iteration < 30; ++iteration) {
    const VectorX f = force(*model, s);
    const MatrixX K = -MatrixX(model->tangent(s, TangentKind::exact).dfdx);
    s.x(free) += solve_symmetric(K(free, free), f(free));
  }
  const VectorX f = force(*model, s);
  double top = 0;
  for (int i = 0; i < model->mesh().num_nodes(); ++i)
    if (model->mesh().x[3 * i + 2] > kEdge - 1e-9) top -= f[3 * i + 2];
  const double exact = bar_stress(GetParam().material, stretch) * kEdge * kEdge;
  std::printf("uniaxial bar, stretch 1.1: off by %.1e\n", std::abs(top / exact - 1));
  EXPECT_NEAR(top, exact, 1e-6 * exact);
}

/// Shear stress P_xy under F = I + gamma e_x e_y^T, by hand.
double shear_stress(const std::string& material, double gamma) {
  const double mu = kYoung / (2 * (1 + kPoisson)), lambda = kYoung * kPoisson / ((1 + kPoisson) * (1 - 2 * kPoisson));
  if (material == "stvk") return mu * gamma + (mu + lambda / 2) * gamma * gamma * gamma;
  if (material == "neo_hookean") return 4.0 / 3.0 * mu * gamma * (1 - 1 / (4 + gamma * gamma));
  if (material == "linear") return mu * gamma;
  const double angle = std::atan(gamma / 2), trace = 1 + 2 * std::sqrt(1 + gamma * gamma / 4);  // of F = R S
  return 2 * mu * (gamma - std::sin(angle)) + lambda * (trace - 3) * std::sin(angle);
}

TEST_P(FemTest, SimpleShear) {
  const double gamma = 0.3;
  const auto model = body(GetParam(), kuhn_block(2, 2, 2, kEdge));
  State s = rest_state(*model);
  for (int i = 0; i < model->mesh().num_nodes(); ++i) s.x[3 * i] += gamma * s.x[3 * i + 1];
  const VectorX f = force(*model, s);
  double top = 0;  // held by the nodes of the face y = 2 edges; what x = 0 and x = 2 edges pull at their ends cancels
  for (int i = 0; i < model->mesh().num_nodes(); ++i)
    if (model->mesh().x[3 * i + 1] > 2 * kEdge - 1e-9) top -= f[3 * i];
  const double exact = shear_stress(GetParam().material, gamma) * 4 * kEdge * kEdge;
  std::printf("simple shear, 0.3: off by %.1e\n", std::abs(top / exact - 1));
  EXPECT_NEAR(top, exact, 1e-6 * exact);
}

}  // namespace
}  // namespace kt
